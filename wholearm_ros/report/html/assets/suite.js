// The report of a suite: tiles, details of the one pressed, times, success.
const S = REPORT, byId = id => document.getElementById(id);
function element(parent, tag, text, attributes = {}) {
  const made = parent.appendChild(document.createElement(tag));
  if (text !== undefined && text !== null) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
const ms = value => value === null ? '' : value < 1000 ? value.toFixed(0) + ' ms' : (value / 1000).toFixed(1) + ' s';
const total = t => (t.plan_ms || 0) + (t.generate_ms || 0) + (t.verify_ms || 0);

// ---- tiles and filters
const hidden = new Set();
const tiles = S.tasks.map((task, k) => {
  const tile = element(byId('tiles'), 'button', task.name, {type: 'button', class: 'tile t-' + task.kind, 'aria-pressed': 'false'});
  if (task.shape) {
    const across = task.shape.map(p => p[0]), up = task.shape.map(p => p[1]), left = Math.min(...across), top = Math.max(...up);
    const size = Math.max(Math.max(...across) - left, top - Math.min(...up));
    const drawing = make(tile, 'svg', {viewBox: `${left - 3} ${-top - 3} ${size + 6} ${size + 6}`, class: 'shape', 'aria-hidden': 'true'});
    make(make(drawing, 'g', {transform: 'scale(1,-1)'}), 'polygon', {class: 'object', points: points(task.shape)});
  }
  element(tile, 'small', S.kinds[task.kind]);
  element(tile, 'small', ms(total(task)));
  tile.addEventListener('click', () => choose(k));
  return tile;
});
for (const [kind, name] of Object.entries(S.kinds)) {
  const count = S.tasks.filter(t => t.kind === kind).length;
  if (!count) continue;
  const button = element(byId('filters'), 'button', `${name}: ${count}`, {type: 'button', class: 'tile t-' + kind, 'aria-pressed': 'true'});
  button.addEventListener('click', () => {
    hidden.has(kind) ? hidden.delete(kind) : hidden.add(kind);
    button.setAttribute('aria-pressed', String(!hidden.has(kind)));
    S.tasks.forEach((t, k) => { tiles[k].hidden = hidden.has(t.kind); });
  });
}

// ---- details
function choose(k) {
  tiles.forEach((tile, i) => tile.setAttribute('aria-pressed', String(i === k)));
  const task = S.tasks[k], box = byId('details');
  box.replaceChildren();
  element(box, 'h2', `${task.name}: ${S.kinds[task.kind]}`);
  const list = element(box, 'dl');
  const tell = (name, value) => { if (value) { element(list, 'dt', name); element(list, 'dd', value); } };
  tell('reason', task.reason);
  tell('times', ['plan', 'generate', 'verify'].map(n => `${n} ${ms(task[n + '_ms'])}`).join(', '));
  tell('subgoals', `${task.subgoals}, ${task.path_length} of them on the route`);
  tell('modes', Object.entries(task.modes || {}).filter(([, s]) => s).map(([m, s]) => `${S.names[m] || m} ${s.toFixed(2)} s`).join(', '));
  tell('final pose', task.final_pose && `x ${task.final_pose[0].toFixed(4)} m, y ${task.final_pose[1].toFixed(4)} m, ${task.final_pose[2].toFixed(4)} rad`);
  if (task.error) element(box, 'pre', task.error);
  if (task.run) showRun(box, task.run);
  if (task.draws.length) {
    const table = element(element(box, 'div', null, {class: 'scroll'}), 'table', null, {class: 'long'}), head = element(element(table, 'thead'), 'tr');
    const columns = ['draw', 'at the goal', 'angle error [rad]', 'what was different', 'reason'];
    columns.forEach(name => element(head, 'th', name));
    const body = element(table, 'tbody');
    task.draws.forEach((draw, i) => {
      const row = element(body, 'tr');
      const different = Object.entries(draw.perturbation || {}).filter(([name, v]) => typeof v === 'number' && v !== 0 && name !== 'noise_seed')
        .map(([name, v]) => `${name.replaceAll('_', ' ')} ${+v.toPrecision(3)}`).join(', ');
      [i, draw.executed ? 'yes' : 'no', draw.angle_error === undefined ? '' : draw.angle_error.toFixed(4), different, draw.reason]
        .forEach((text, c) => element(row, 'td', text, {'data-name': columns[c]}));
    });
  }
}

// ---- the run of the task that was pressed: it plays by itself, the slider stops it
let playing = 0;
function showRun(box, run) {
  const mine = ++playing, last = run.pose.length - 1, end = last * run.period;
  const stage = element(box, 'div', null, {class: 'stage'});
  const {move} = makeScene(stage.appendChild(document.createElementNS(SVG, 'svg')), run.scene);
  const slider = element(stage, 'input', null, {type: 'range', min: 0, max: end, step: 0.01, 'aria-label': 'Time [s]', class: 'slider'});
  const line = element(stage, 'p', null, {class: 'key'}), play = element(line, 'button', 'Pause', {type: 'button'});
  const chip = element(line, 'span', '', {class: 'chip'}), clock = element(line, 'output');
  let began = performance.now();
  function show(t) {
    const k = Math.min(Math.floor(t / run.period), last), next = Math.min(k + 1, last), u = Math.min(t / run.period - k, 1);
    const between = list => list[k].map((v, i) => v + u * (list[next][i] - v));
    move(between(run.pose), between(run.angles));
    slider.value = t;
    chip.textContent = S.names[run.modes[k]] || run.modes[k];
    chip.style.background = S.colours[run.modes[k]];
    clock.textContent = ` ${t.toFixed(2)} of ${end.toFixed(2)} s`;
  }
  function step(stamp) {
    if (began === null || mine !== playing) return;
    show(Math.min(Math.max(stamp - began, 0) / 1000, end));
    if ((stamp - began) / 1000 < end) requestAnimationFrame(step); else pause();
  }
  function pause() { began = null; play.textContent = 'Play'; }
  play.addEventListener('click', () => {
    if (began !== null) return pause();
    began = performance.now() - 1000 * (slider.value >= end ? 0 : slider.value);
    play.textContent = 'Pause';
    requestAnimationFrame(step);
  });
  slider.addEventListener('input', () => { pause(); show(+slider.value); });
  show(0);
  requestAnimationFrame(step);
}

// ---- plots
const order = S.tasks.map((_, k) => k).sort((a, b) => total(S.tasks[b]) - total(S.tasks[a]));
const stages = ['plan', 'generate', 'verify'], inks = ['#8cbfe6', '#f2a65a', '#7cc6a4'];
if (order.length) makeBars(byId('times'), {
  bars: order.map(k => ({name: S.tasks[k].name, parts: stages.map(stage => (S.tasks[k][stage + '_ms'] || 0) / 1000)})),
  kinds: stages.map((name, i) => ({name, colour: inks[i]})), title: 'seconds', pick: k => choose(order[k])});
const told = S.levels.filter(l => l.share !== null);
if (told.length > 1) makeShares(byId('success'), {points: told.map(l => ({...l, x: l.level, text: `${l.done}/${l.runs}`})),
  title: 'share at the goal', xTitle: 'perturbation level'});
else {
  const percent = v => (100 * v).toFixed(0) + ' %', only = told[0];
  byId('success').classList.remove('plot');
  byId('success').textContent = only ? `At level ${only.level} ${only.done} of ${only.runs} runs end at the goal: ` +
    `${percent(only.share)}, by the 95 % interval ${percent(only.low)} to ${percent(only.high)}.` : 'Nothing was executed.';
}
