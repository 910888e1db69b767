// Draw a polygon: drag, add, remove, snap; what is wrong is said at once by the project's own checks.
function makeBoard(link, mayCommand) {
  const board = byId('board'), state = {base: null, points: [], chosen: 0, wrong: {vertices: [], edges: []}};
  let world = null, grabbed = null, waiting = null, checking = false;

  // ---- the polygon
  const snapped = v => { const s = +byId('snap').value; return s ? Math.round(v / s) * s : v; };
  function settled(k, point) {  // onto the grid, and onto an angle of the edge from the vertex before
    const step = +byId('degrees').value * Math.PI / 180, n = state.points.length, before = state.points[(k + n - 1) % n];
    if (!step) return point.map(snapped);
    const length = snapped(Math.hypot(point[0] - before[0], point[1] - before[1])) || 1;
    const angle = Math.round(Math.atan2(point[1] - before[1], point[0] - before[0]) / step) * step;
    return [before[0] + length * Math.cos(angle), before[1] + length * Math.sin(angle)];
  }
  function moveTo(k, point) {
    state.points[k] = settled(k, point).map(v => +Math.min(Math.max(v, -500), 500).toFixed(3));
    drawn();
  }
  function add(edge) {
    if (state.points.length >= 64) return;
    const a = state.points[edge], b = state.points[(edge + 1) % state.points.length];
    const out = [b[1] - a[1], a[0] - b[0]], length = Math.hypot(...out) || 1;  // a little out, or it would be no corner
    state.points.splice(edge + 1, 0, [0, 1].map(i => +((a[i] + b[i]) / 2 + 3 * out[i] / length).toFixed(3)));
    state.chosen = edge + 1;
    fill();
  }
  function remove() {
    if (state.points.length <= 3) return;
    state.points.splice(state.chosen, 1);
    state.chosen %= state.points.length;
    fill();
  }

  // ---- the picture
  function fit() {
    const xs = state.points.map(p => p[0]), ys = state.points.map(p => p[1]);
    const middle = [(Math.min(...xs) + Math.max(...xs)) / 2, (Math.min(...ys) + Math.max(...ys)) / 2];
    const half = 30 + Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 40) / 2;
    board.setAttribute('viewBox', [middle[0] - 1.25 * half, -middle[1] - half, 2.5 * half, 2 * half].join(' '));
  }
  function fill() {  // all elements anew, after a vertex came or went
    board.replaceChildren();
    world = make(board, 'g', {transform: 'scale(1,-1)'});
    for (let v = -500; v <= 500; v += 10) {
      make(world, 'line', {class: 'grid', x1: v, x2: v, y1: -500, y2: 500});
      make(world, 'line', {class: 'grid', y1: v, y2: v, x1: -500, x2: 500});
    }
    make(world, 'polygon', {class: 'object'});
    state.points.forEach((_, k) => {
      const hit = make(world, 'line', {class: 'board-hit'});
      make(world, 'line', {class: 'board-edge', 'pointer-events': 'none'});
      make(world, 'text', {class: 'board-text'});
      hit.addEventListener('click', () => add(k));
    });
    state.points.forEach((_, k) => {
      const hit = make(world, 'circle', {class: 'vertex-hit', r: 7});
      const dot = make(world, 'circle', {class: 'vertex', r: 2.6, tabindex: 0, role: 'button'});
      for (const one of [hit, dot]) one.addEventListener('pointerdown', event => grab(k, event));
      dot.addEventListener('focus', () => { state.chosen = k; drawn(false); });
      dot.addEventListener('keydown', event => key(k, event));
    });
    fit();
    edges();
    drawn();
  }
  function drawn(check = true) {
    const n = state.points.length;
    world.querySelector('.object').setAttribute('points', points(state.points));
    world.querySelectorAll('.board-hit').forEach((e, k) => ends(e, k));
    world.querySelectorAll('.board-edge').forEach((e, k) => { ends(e, k); e.classList.toggle('wrong', state.wrong.edges.includes(k)); });
    world.querySelectorAll('.board-text').forEach((e, k) => {
      const a = state.points[k], b = state.points[(k + 1) % n], d = [b[0] - a[0], b[1] - a[1]], length = Math.hypot(...d) || 1;
      const at = [0, 1].map(i => (a[i] + b[i]) / 2 + [d[1], -d[0]][i] / length * (6 + 7 * Math.abs(d[1]) / length));
      e.setAttribute('transform', `translate(${at}) scale(1,-1)`);
      e.textContent = `${k}: ${length.toFixed(1)}`;
    });
    for (const kind of ['.vertex-hit', '.vertex']) world.querySelectorAll(kind).forEach((e, k) => {
      e.setAttribute('cx', state.points[k][0]);
      e.setAttribute('cy', state.points[k][1]);
      e.classList.toggle('wrong', state.wrong.vertices.includes(k));
      e.classList.toggle('chosen', state.chosen === k);
      e.setAttribute('aria-label', `vertex ${k}: ${state.points[k][0].toFixed(1)}, ${state.points[k][1].toFixed(1)} mm`);
    });
    if (check) askForCheck();
  }
  function ends(line, k) {
    const a = state.points[k], b = state.points[(k + 1) % state.points.length];
    for (const [name, value] of Object.entries({x1: a[0], y1: a[1], x2: b[0], y2: b[1]})) line.setAttribute(name, value);
  }

  // ---- by hand
  function at(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(world.getScreenCTM().inverse());
    return [point.x, point.y];
  }
  function grab(k, event) {
    event.preventDefault();
    grabbed = k;
    state.chosen = k;
    board.setPointerCapture(event.pointerId);
    world.querySelectorAll('.vertex')[k].focus({preventScroll: true});
  }
  board.addEventListener('pointermove', event => { if (grabbed !== null) moveTo(grabbed, at(event)); });
  for (const end of ['pointerup', 'pointercancel']) board.addEventListener(end, () => { if (grabbed !== null) { grabbed = null; fit(); } });
  const STEPS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  function key(k, event) {
    const step = STEPS[event.key], size = (+byId('snap').value || 0.1) * (event.shiftKey ? 5 : 1);
    if (step) {
      state.points[k] = state.points[k].map((v, i) => +(snapped(v + size * step[i])).toFixed(3));
      drawn();
    } else if (event.key === 'Insert') add(k);
    else if (event.key === 'Delete') remove();
    else return;
    event.preventDefault();
    if (!step) world.querySelectorAll('.vertex')[state.chosen].focus();
  }
  byId('add').addEventListener('click', () => add(state.chosen));
  byId('remove').addEventListener('click', remove);

  // ---- the rest of the scenario
  function edges() {
    for (const id of ['start-edge', 'goal-edge']) {
      const kept = byId(id).value;
      byId(id).replaceChildren(...state.points.map((_, k) => new Option(`edge ${k}`, k)));
      byId(id).value = kept && +kept < state.points.length ? kept : 0;
    }
  }
  const fields = ['mass', 'start-edge', 'start-x', 'goal-edge', 'goal-direction', 'scenario-name'];
  fields.forEach(id => byId(id).addEventListener('input', () => askForCheck()));
  function scenario() {
    const {hand, palm, gravity} = state.base, direction = byId('goal-direction').value;
    return {name: byId('scenario-name').value, hand, palm, gravity,
      object: {vertices: state.points.map(p => p.map(v => v / 1000)), mass: +byId('mass').value},
      start: {edge: +byId('start-edge').value, x: +byId('start-x').value / 1000},
      goal: {edge: +byId('goal-edge').value, ...(direction && {direction})}};
  }
  function open(told) {
    state.base = told;
    state.points = told.object.vertices.map(p => p.map(v => +(1000 * v).toFixed(3)));
    state.chosen = 0;
    fill();
    byId('mass').value = told.object.mass;
    byId('start-edge').value = told.start.edge || 0;
    byId('start-x').value = told.start.x === undefined ? 0 : +(1000 * told.start.x).toFixed(2);
    byId('goal-edge').value = told.goal.edge || 0;
    byId('goal-direction').value = told.goal.direction || '';
    byId('scenario-name').value = (told.name || 'drawn').replace(/[^A-Za-z0-9_.-]/g, '_');
    askForCheck();
  }
  const sayIn = id => answer => {
    byId(id).textContent = answer.message;
    byId(id).className = answer.ok ? '' : 'bad';
  };
  const say = sayIn('draw-answer'), sayOpened = sayIn('opened');

  // ---- what is said at once: one check at a time, of the newest
  async function askForCheck() {
    waiting = state.base && scenario();
    if (checking || !waiting) return;
    checking = true;
    while (waiting) {
      const asked = waiting;
      waiting = null;
      const answer = await link.send({type: 'check', scenario: asked});
      if (answer.ok && !waiting) told(answer.checked);
    }
    checking = false;
  }
  function told(checked) {
    const gather = kind => checked.problems.flatMap(p => p[kind]);
    state.wrong = {vertices: gather('vertices'), edges: gather('edges')};
    byId('problems').replaceChildren();
    checked.problems.forEach(p => element(byId('problems'), 'li', p.text, {class: 'bad'}));
    if (!checked.problems.length) element(byId('problems'), 'li', 'convex, and both fingers reach it at the start', {class: 'good'});
    byId('drawn-faces').replaceChildren();
    const within = (checked.faces || []).filter(f => !f.reach).map(f => f.edge);
    if (checked.faces) element(byId('drawn-faces'), 'p', `It rests within reach of both fingers on edge ${within.join(', ') || 'none'}.`, {class: 'key'});
    (checked.faces || []).filter(f => f.reach).forEach(f => element(byId('drawn-faces'), 'p', `Edge ${f.edge}: ${f.reach}`, {class: 'key bad'}));
    if (checked.centroid) element(byId('drawn-faces'), 'p', `Area ${checked.area} cm², centroid at ${checked.centroid.join(', ')} mm.`, {class: 'key'});
    drawn(false);
  }

  // ---- files
  byId('open').addEventListener('change', async () => {
    const answer = await link.send({type: 'open', name: byId('open').value});
    sayOpened(answer);
    if (answer.ok) open(answer.scenario);
  });
  byId('import').addEventListener('change', async () => {
    const file = byId('import').files[0];
    if (!file) return;
    const kind = file.name.toLowerCase().endsWith('.dxf') ? 'dxf' : 'svg';
    if (file.size > 400000) return sayOpened({ok: false, message: `${file.name}: got ${file.size} bytes; allowed: at most 400000`});
    const answer = await link.send({type: 'import', kind, text: await file.text()});
    sayOpened(answer);
    byId('import').value = '';
    if (!answer.ok) return;
    state.points = answer.vertices;
    state.chosen = 0;
    fill();
  });
  async function save(replace) {
    const answer = await link.send({type: 'save', name: byId('scenario-name').value, scenario: scenario(), replace});
    if (!answer.ok && answer.message.includes('exists already') && !replace && await confirmed('A scenario of this name exists. Replace it?')) return save(true);
    say(answer);
    files();
  }
  byId('save').addEventListener('click', () => save(false));
  byId('load').addEventListener('click', async () => say(await link.send({type: 'load', scenario: scenario()})));
  let making = false;
  byId('map-drawn').addEventListener('click', async () => {
    if (!making) byId('map-lines').replaceChildren();
    say(await link.send({type: 'map', on: !making, ...(making ? {} : {scenario: scenario()})}));
  });
  link.on('job', message => {
    making = message.running;
    byId('map-drawn').textContent = making ? 'End' : 'Find out';
    if (message.line) element(byId('map-lines'), 'div', message.line).scrollIntoView({block: 'nearest'});
  });
  function names(list) { byId('open').replaceChildren(new Option('…', ''), ...list.map(name => new Option(name, name))); }
  async function files() {
    const answer = await link.send({type: 'files'});
    if (answer.ok) names(answer.scenarios);
  }
  return {open, names, isEmpty: () => state.base === null};
}
