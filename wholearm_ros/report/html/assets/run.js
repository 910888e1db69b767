// The report of one run: a scene, a slider, plots and a graph that show the same instant.
const R = REPORT, T = R.times, last = T.length - 1;
const byId = id => document.getElementById(id);
const shown = {k: -1, t: T[0]};

const draw = makeRunScene(byId('scene'), R);

// ---- plots
const broken = list => list.map((v, i) => i && R.torque_side[i] !== R.torque_side[i - 1] ? null : v);
const both = (planned, executed) => [{name: 'planned', kind: 'plan', y: broken(planned)}, {name: 'executed', kind: 'executed', y: broken(executed)}];
const moveCursor = makeLines(byId('plots'), {
  x: T, title: 'time [s]', spans: R.planned_modes.map(([a, b, mode]) => [a, b, R.colours[mode]]),
  entries: [...(R.low.some(v => v !== null) ? [{name: 'feasible (τ_min, τ_max)', kind: 'hatched'}] : []),
    {name: 'planned', kind: 'plan'}, {name: 'executed', kind: 'executed'}],
  panels: [
    {title: 'pressing torque [N m]', share: 0.48, range: R.torque_window, note: R.torque_note,
      region: {low: broken(R.low), high: broken(R.high)}, lines: both(R.planned_torque, R.torque)},
    {title: 'velocity finger [°]', share: 0.3, lines: both(R.planned_angle, R.angle)},
    {title: 'error [mrad]', share: 0.22, lines: [{name: 'error', kind: 'executed', y: broken(R.error)}]}],
  pick: t => { stop(); show(t); },
});

// ---- time
const slider = byId('time'), now = byId('now'), play = byId('play');
Object.assign(slider, {min: T[0], max: T[last], step: 0.005});

function show(t) {
  t = Math.min(Math.max(+t, T[0]), T[last]);
  let k = 0, end = last;
  while (end - k > 1) { const middle = (k + end) >> 1; if (T[middle] <= t) k = middle; else end = middle; }
  if (t >= T[last]) k = last;
  shown.k = k; shown.t = t;
  draw(k, k < last ? (t - T[k]) / (T[k + 1] - T[k]) : 0);
  slider.value = t;
  const side = R.sides[R.torque_side[k]];
  now.textContent = `${t.toFixed(2)} s  ${R.names[R.modes[k]] || R.modes[k]}  torque (${side}) ${R.torque[k].toFixed(2)} N m` +
    `  error ${R.error[k].toFixed(1)} mrad`;
  moveCursor(t);
}

let running = null;
function stop() { running = null; play.textContent = 'Play'; play.setAttribute('aria-label', 'Play'); }
function step(stamp) {
  if (running === null) return;
  const t = shown.t + (stamp - running) / 1000 * byId('speed').value;
  running = stamp;
  show(t);
  if (t >= T[last]) stop(); else requestAnimationFrame(step);
}
play.addEventListener('click', () => {
  if (running !== null) return stop();
  if (shown.t >= T[last]) show(T[0]);
  running = performance.now(); play.textContent = 'Pause'; play.setAttribute('aria-label', 'Pause');
  requestAnimationFrame(step);
});
slider.addEventListener('input', () => { stop(); show(slider.value); });

// ---- keys: space plays, arrows step, wherever the focus is, unless what has it needs the key itself
const STEPS = {ArrowLeft: -0.05, ArrowRight: 0.05, PageDown: -0.5, PageUp: 0.5};  // [s]
document.addEventListener('keydown', event => {
  const own = event.target.closest('button, select, summary, [role=button]'), scrolls = event.target.closest('.scroll');
  if (event.ctrlKey || event.altKey || event.metaKey || own) return;
  if (event.key === ' ') play.click();
  else if (STEPS[event.key] && !(scrolls || (event.key.startsWith('Page') && event.target !== slider))) { stop(); show(shown.t + STEPS[event.key]); }
  else return;
  event.preventDefault();
});

// ---- band of modes, chips, graph
const full = T[last] - T[0];
R.executed_modes.forEach(([a, b, mode]) => {
  const span = byId('band').appendChild(document.createElement('span'));
  Object.assign(span.style, {left: 100 * (a - T[0]) / full + '%', width: 100 * (b - a) / full + '%', background: R.colours[mode]});
  span.textContent = (b - a) / full > 0.09 ? R.names[mode] : '';
  span.title = `${R.names[mode]} ${a.toFixed(2)} to ${b.toFixed(2)} s`;
});
for (const [number, t] of Object.entries(R.subgoal_times)) {
  const frame = byId('subgoal-' + number);
  if (!frame) continue;
  frame.dataset.time = t;
  for (const [name, value] of [['tabindex', 0], ['role', 'button'], ['aria-label', `Subgoal ${number}, at ${t.toFixed(2)} s`]]) frame.setAttribute(name, value);
}
document.querySelectorAll('[data-time]').forEach(element => {
  const go = () => { stop(); show(element.dataset.time); byId('stage').scrollIntoView({behavior: 'smooth', block: 'nearest'}); };
  element.addEventListener('click', go);
  if (element.tagName !== 'BUTTON') element.addEventListener('keydown', event => {
    if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); go(); }
  });
});
show(0);
