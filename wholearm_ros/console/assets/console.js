// The page: what is heard goes to its place, what is pressed goes to the console, Stop before everything.
const link = makeLink(), live = makeLive(choose), board = makeBoard(link), bags = makeBags(link);
const me = {page: null, holder: null, chosen: null, status: '', graph: null, mode: '', stopped: -1e9, names: {}, colours: {}};
const inControl = () => me.page !== null && me.holder === me.page;

// ---- Stop: by pointer as soon as it is down, by the space bar wherever the focus is
const AGAIN_WITHIN = 3000;  // [ms] after a stop, another one stops the drives
async function stop(drives) {
  const began = performance.now(), text = byId('stop-text');
  text.className = '';
  text.textContent = 'Stop was sent, no answer yet …';
  const late = setTimeout(() => { text.className = 'bad'; text.textContent = 'No answer to Stop: use the emergency stop of the hand.'; }, 1000);
  const answer = await link.send({type: 'stop', drives});
  clearTimeout(late);
  if (answer.ok) me.stopped = began;
  text.className = answer.ok ? 'good' : 'bad';
  text.textContent = answer.ok ? `${answer.message} (${(performance.now() - began).toFixed(0)} ms)`
    : answer.lost ? 'Stop did not reach the hand: use its emergency stop.' : answer.message;
}
for (const [id, drives] of [['stop', false], ['stop-drives', true]]) {
  byId(id).addEventListener('pointerdown', event => { if (event.button === 0) stop(drives); });
  byId(id).addEventListener('click', event => { if (event.detail === 0) stop(drives); });  // by the Enter key
}
for (const kind of ['keydown', 'keyup']) document.addEventListener(kind, event => {
  if (event.code !== 'Space') return;
  event.preventDefault();
  event.stopPropagation();
  if (kind === 'keydown' && !event.repeat) stop(performance.now() - me.stopped < AGAIN_WITHIN);
}, true);

document.addEventListener('keydown', event => {  // what the space bar does elsewhere
  if (event.key !== 'Enter' || !event.target.matches('[type=checkbox], [type=file]')) return;
  event.preventDefault();
  event.target.click();
});

// ---- a question that does not hold up the page: Stop works meanwhile
function confirmed(question) {
  const dialog = byId('ask');
  byId('ask-text').textContent = question;
  return new Promise(answer => {
    let yes = false;
    byId('ask-yes').onclick = () => { yes = true; dialog.close(); };
    byId('ask-no').onclick = () => dialog.close();
    dialog.onclose = () => answer(yes);
    dialog.onkeydown = event => { if (event.key === 'Escape') dialog.close(); };
    dialog.show();
    byId('ask-no').focus();
  });
}

// ---- control
byId('control').addEventListener('click', async () => {
  if (inControl()) return link.send({type: 'control', how: 'release'});
  const answer = await link.send({type: 'control', how: 'ask'});
  if (answer.ok || answer.lost) return;
  if (await confirmed(`Page ${me.holder} has control. Take it over? That page is told.`)) link.send({type: 'control', how: 'take'});
});
link.on('control', message => {
  const had = inControl();
  me.holder = message.holder;
  const others = message.pages - 1, looking = others === 1 ? ', 1 other page looks' : others ? `, ${others} other pages look` : '';
  byId('control').textContent = inControl() ? 'Give control up' : me.holder === null ? 'Ask for control' : 'Take control over';
  byId('control-text').textContent = (inControl() ? 'This page has control' : me.holder === null ? 'Nobody has control'
    : `Page ${me.holder} has control, this one looks on`) + looking;
  if (had && !inControl() && me.holder !== null) say({ok: false, message: `page ${me.holder} has taken control over`});
  enable();
});

// ---- commands
function say(answer) {
  byId('answer').textContent = answer.message;
  byId('answer').className = answer.ok ? '' : 'bad';
}
function choose(edge) {
  me.chosen = edge;
  live.choose(edge);
  byId('faces').querySelectorAll('button').forEach(b => b.setAttribute('aria-checked', String(+b.dataset.edge === edge)));
  enable();
}
byId('faces').addEventListener('keydown', event => {
  const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key], all = [...byId('faces').children];
  if (!step) return;
  event.preventDefault();
  const next = all[(all.indexOf(event.target) + step + all.length) % all.length];
  next.focus();
  choose(+next.dataset.edge);
});
function enable() {
  const may = link.isAlive() && inControl(), ready = may && me.status === 'ready';
  byId('turn').disabled = !(ready && me.chosen !== null);
  for (const id of ['feel', 'cancel', 'reset']) byId(id).disabled = !ready;
  for (const id of ['save', 'load', 'map-drawn', 'record', 'restart']) byId(id).disabled = !may;
  byId('turn').textContent = me.chosen === null ? 'Turn' : `Turn onto edge ${me.chosen}`;
}
byId('turn').addEventListener('click', async () => say(await link.send({type: 'turn', edge: me.chosen})));
for (const id of ['feel', 'cancel', 'reset', 'restart']) byId(id).addEventListener('click', async () => say(await link.send({type: id})));

// ---- what is heard
link.on('hello', message => {
  me.page = message.page;
  byId('log').replaceChildren();
  board.names(message.scenarios);
  bags.list();
  link.send({type: 'control', how: 'ask'});  // given when nobody has it
});
link.on('graph', message => {
  me.graph = message;
  me.status = message.status;
  showGraph();
  byId('graph-text').textContent = message.status === 'failed' ? message.text : message.text && `waiting for: ${message.text}`;
  byId('restart').hidden = message.join || message.status !== 'failed';
  if (message.status !== 'ready') live.reset();
  enable();
});
function showGraph() {
  const status = link.isAlive() && me.graph ? me.graph.status : 'no connection';
  byId('graph-chip').textContent = status;
  byId('graph-chip').className = `chip ${link.isAlive() ? status : 'failed'}`;
}
link.on('scene', message => {
  me.names = message.names;
  me.colours = message.colours;
  me.chosen = null;
  live.setScene(message);
  if (board.isEmpty()) board.open(message.scenario);
  enable();
});
link.on('frame', message => { live.show(message); showMode(message.m); });
function showMode(mode) {
  if (mode === me.mode) return;
  me.mode = mode;
  byId('mode-chip').hidden = !mode;
  byId('mode-chip').textContent = me.names[mode] || mode;
  byId('mode-chip').style.background = me.colours[mode];
}
link.on('faces', message => {
  const chosen = me.chosen, had = document.activeElement && document.activeElement.dataset.edge;
  byId('faces').replaceChildren();
  message.faces.forEach(face => {
    const button = element(byId('faces'), 'button', `edge ${face.edge}`, {type: 'button', role: 'radio', 'data-edge': face.edge, 'aria-checked': 'false'});
    element(button, 'small', face.told);
    button.addEventListener('click', () => choose(face.edge));
    if (had === String(face.edge)) button.focus();
  });
  byId('map-line').replaceChildren(`${message.map}. `);
  element(byId('map-line'), 'a', 'The map', {href: 'map', target: '_blank', rel: 'noopener'});
  live.setFaces(message.faces);
  if (chosen !== null && message.faces.some(f => f.edge === chosen)) choose(chosen);
});
link.on('state', message => {
  showMode(message.mode);
  const attempt = message.attempt && `attempt ${message.attempt} of ${message.attempts}: `;
  const place = message.place ? `It lies on edge ${message.place.edge} at x = ${message.place.x} mm.` : '';
  const reached = place && message.outcome === 'succeeded' ? message.outcome : message.reached;
  const ended = reached || message.felt || (message.mode === 'probing' ? 'feeling' : '');
  byId('run-line').textContent = message.phase ? `${attempt}${message.phase}` : [ended, place].filter(Boolean).join('. ');
  byId('run-line').className = message.phase ? '' : message.outcome === 'succeeded' ? 'good' : message.outcome ? 'bad' : '';
  byId('run-progress').value = message.progress;
  byId('run-progress').hidden = !message.phase;
  byId('tries').replaceChildren();
  message.tries.forEach(one => element(byId('tries'), 'li', one.text.replace(/^\d+\. /, ''), {class: one.claimed === 'at_goal' ? 'good' : ''}));
});
link.on('loop', message => {
  const rows = {'joint states': message.age === null ? 'none yet' : message.age > 0.4 ? `none for ${message.age.toFixed(1)} s` : 'coming',
    'rate': message.rate ? `${message.rate.toFixed(0)} Hz` : '', drives: message.drives, ...message.figures};
  byId('loop').replaceChildren();
  for (const [name, value] of Object.entries(rows)) {
    if (value === '') continue;
    element(byId('loop'), 'dt', name);
    element(byId('loop'), 'dd', shown(value), {class: String(value).startsWith('none') ? 'bad' : ''});
  }
  byId('nodes').replaceChildren();
  for (const [name, node] of Object.entries(message.nodes)) {
    const row = element(byId('nodes'), 'tr');
    element(row, 'td', name);
    element(row, 'td', node.level, {class: {ok: 'good', warning: 'unknown'}[node.level] || 'bad'});
    element(row, 'td', node.message);
  }
});
const shown = value => /^-?\d+\.\d+$/.test(value) ? String(+(+value).toPrecision(3)) : value;
const MOST_LINES = 300;
link.on('log', message => {
  const log = byId('log'), below = log.scrollHeight - log.scrollTop - log.clientHeight < 30;
  message.lines.forEach(line => {
    const time = new Date(1000 * line.time).toLocaleTimeString();
    element(log, 'div', `${time} ${line.node}: ${line.text}`, {class: line.level});
  });
  while (log.children.length > MOST_LINES) log.firstChild.remove();
  filterLog();
  if (below) log.scrollTop = log.scrollHeight;
});
function filterLog() {
  const only = byId('only-warnings').checked;
  [...byId('log').children].forEach(line => { line.hidden = only && line.className === 'info'; });
}
byId('only-warnings').addEventListener('change', filterLog);
link.on('note', message => say({ok: message.level !== 'error', message: message.text}));

// ---- the connection
link.on('alive', alive => {
  byId('lost').hidden = alive;
  for (const id of ['stop', 'stop-drives']) byId(id).classList.toggle('dead', !alive);
  byId('stop-text').textContent = '';
  if (alive) byId('login').hidden = true;
  else live.reset();
  showGraph();
  enable();
});
const AGAIN = 1000;  // [ms] between two attempts to connect
async function open() {
  try {
    const needed = await (await fetch('login')).text() === 'token';
    byId('login').hidden = !needed;
    if (needed) byId('lost').hidden = true;
    else link.connect();
  } catch {  // it is gone
    byId('lost').hidden = false;
    setTimeout(open, AGAIN);
  }
}
link.on('closed', () => setTimeout(open, AGAIN));
async function logIn(token) {
  try {
    const answer = await fetch('login', {method: 'POST', body: token});
    byId('login-text').textContent = answer.ok ? '' : await answer.text();
  } catch { byId('login-text').textContent = 'no connection'; }
  open();
}
byId('login').addEventListener('submit', event => { event.preventDefault(); logIn(byId('token').value); });

// ---- views
const views = ['hand', 'draw', 'bags'];
function view(name) {
  views.forEach(one => {
    byId(one).hidden = one !== name;
    byId(`tab-${one}`).setAttribute('aria-selected', String(one === name));
  });
  if (name === 'bags') bags.list();
}
views.forEach((name, k) => {
  byId(`tab-${name}`).addEventListener('click', () => view(name));
  byId(`tab-${name}`).addEventListener('keydown', event => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (step) { const next = views[(k + step + views.length) % views.length]; view(next); byId(`tab-${next}`).focus(); }
  });
});

(async () => {
  if (location.hash.length > 1) {  // the token of the printed address; it goes to nobody but /login
    const token = location.hash.slice(1);
    history.replaceState(null, '', location.pathname);
    await logIn(token);
  } else open();
})();
