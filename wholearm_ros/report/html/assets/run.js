// The report of one run: a scene, a slider, plots and a graph that show the same instant.
const R = REPORT, T = R.times, last = T.length - 1;
const byId = id => document.getElementById(id);
const shown = {k: -1, t: T[0]};

const draw = makeRunScene(byId('scene'), R);

// ---- plots
const band = (a, b, mode) => ({type: 'rect', xref: 'x', yref: 'paper', x0: a, x1: b, y0: 0, y1: 1, layer: 'below',
  line: {width: 0}, fillcolor: R.colours[mode], opacity: 0.28});
const cursor = t => ({type: 'line', xref: 'x', yref: 'paper', x0: t, x1: t, y0: 0, y1: 1,
  line: {color: colour('accent'), width: 2}});
const bands = R.planned_modes.map(m => band(...m));

function stretches() {  // closed outlines of the feasible range, a gap between them
  const x = [], y = [];
  for (let i = 0; i <= last; i++) {
    if (R.low[i] === null) continue;
    let j = i;
    while (j < last && R.low[j + 1] !== null && R.torque_side[j + 1] === R.torque_side[i]) j++;
    for (let k = i; k <= j; k++) { x.push(T[k]); y.push(R.high[k]); }
    for (let k = j; k >= i; k--) { x.push(T[k]); y.push(R.low[k]); }
    x.push(null); y.push(null);
    i = j;
  }
  return {x, y};
}
const broken = list => list.map((v, i) => i && R.torque_side[i] !== R.torque_side[i - 1] ? null : v);

function traces() {
  const line = (y, name, colourName, axis, width, legend) => ({x: T, y, name, yaxis: axis, mode: 'lines',
    line: {color: colour(colourName), width}, legendgroup: name, showlegend: legend, hovertemplate: '%{y:.3f}'});
  return [
    {...stretches(), name: 'feasible (τ_min, τ_max)', fill: 'toself', fillcolor: 'rgba(0,0,0,0)', mode: 'lines', hoverinfo: 'skip',
      fillpattern: {shape: '/', fgcolor: colour('soft'), size: 7, solidity: 0.18, fillmode: 'overlay'},
      line: {color: colour('soft'), width: 0.7}, showlegend: R.low.some(v => v !== null)},
    line(broken(R.planned_torque), 'planned', 'planned', 'y', 3, true), line(broken(R.torque), 'executed', 'accent', 'y', 1.4, true),
    line(broken(R.planned_angle), 'planned', 'planned', 'y2', 3, false), line(broken(R.angle), 'executed', 'accent', 'y2', 1.4, false),
    line(broken(R.error), 'error', 'accent', 'y3', 1.4, false)];
}
function layout() {
  const axis = (title, domain) => ({...axisTheme(), title: {text: title, font: {size: 11}}, domain, fixedrange: true});
  return {...plotTheme(), margin: {l: 58, r: 10, t: 30, b: 38}, hovermode: 'x unified', dragmode: false,
    legend: {orientation: 'h', y: 1.0, yanchor: 'bottom', x: 0}, hoverlabel: {bgcolor: colour('card')},
    xaxis: {...axisTheme(), title: {text: 'time [s]', font: {size: 11}}, range: [T[0], T[last]], fixedrange: true, anchor: 'y3'},
    yaxis: {...axis('pressing torque [N m]', [0.56, 1]), range: R.torque_window},
    yaxis2: axis('velocity finger [°]', [0.25, 0.51]), yaxis3: axis('error [mrad]', [0, 0.19]),
    annotations: [{text: R.torque_note, xref: 'paper', yref: 'paper', x: 1, y: 0.995, xanchor: 'right', yanchor: 'top',
      showarrow: false, font: {size: 10, color: colour('soft')}}],
    shapes: [...bands, cursor(shown.t)]};
}
const plots = byId('plots');
Plotly.newPlot(plots, traces(), layout(), plotOptions);
plots.on('plotly_click', event => { stop(); show(event.points[0].x); });
dark.addEventListener('change', () => Plotly.react(plots, traces(), layout(), plotOptions));

let waiting = false;
function moveCursor() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    const name = `shapes[${bands.length}]`;
    Plotly.relayout(plots, {[name + '.x0']: shown.t, [name + '.x1']: shown.t});
  });
}

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
  moveCursor();
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
  if (frame) frame.dataset.time = t;
}
document.querySelectorAll('[data-time]').forEach(element => element.addEventListener('click', () => {
  stop(); show(element.dataset.time); byId('stage').scrollIntoView({behavior: 'smooth', block: 'nearest'});
}));
show(0);
