// A face map: pick a start and a face, see the plans of the route play one after the other.
const M = REPORT, byId = id => document.getElementById(id);
const {move} = makeScene(byId('scene'), M.scene);
function option(select, value, text) {
  const made = select.appendChild(document.createElement('option'));
  made.value = value;
  made.textContent = text;
}
M.starts.forEach((start, k) => option(byId('from'), k, `edge ${start.edge}, x ${(1000 * start.x).toFixed(0)} mm`));

let route = [], leg = 0, began = null;
function chooseStart() {
  const kept = byId('to').value;
  byId('to').replaceChildren();
  M.routes.filter(r => r.start === +byId('from').value).forEach(r => option(byId('to'), r.face, `edge ${r.face}, ${(100 * r.success_rate).toFixed(0)} %`));
  byId('to').value = kept;
  if (byId('to').selectedIndex < 0) byId('to').selectedIndex = 0;
  chooseRoute();
}
function chooseRoute() {
  const found = M.routes.find(r => r.start === +byId('from').value && r.face === +byId('to').value);
  route = found ? found.ways : [];
  byId('legs').replaceChildren(...route.map(way => {
    const line = document.createElement('li');
    line.textContent = M.ways[way].told;
    return line;
  }));
  leg = 0;
  began = null;
  byId('play').textContent = 'Play';
  if (route.length) show(M.ways[route[0]], 0);
}
function show(way, t) {
  const last = way.pose.length - 1, k = Math.min(Math.floor(t / M.period), last), next = Math.min(k + 1, last);
  const u = Math.min(t / M.period - k, 1), between = list => list[k].map((v, i) => v + u * (list[next][i] - v));
  move(between(way.pose), between(way.angles));
  byId('mode').textContent = M.names[way.modes[k]] || way.modes[k];
  byId('mode').style.background = M.colours[way.modes[k]];
  byId('clock').textContent = ` leg ${leg + 1} of ${route.length}, ${t.toFixed(2)} s`;
}
function step(stamp) {
  if (began === null) return;
  const way = M.ways[route[leg]], t = (stamp - began) / 1000, end = (way.pose.length - 1) * M.period;
  show(way, Math.min(t, end));
  [...byId('legs').children].forEach((line, i) => { line.style.fontWeight = i === leg ? '600' : ''; });
  if (t > end + 0.6) {
    leg += 1;
    began = stamp;
  }
  if (leg < route.length) return requestAnimationFrame(step);
  leg = 0;
  began = null;
  byId('play').textContent = 'Play';
}
byId('play').addEventListener('click', () => {
  const stopped = began === null;
  byId('play').textContent = stopped ? 'Pause' : 'Play';
  began = stopped && route.length ? performance.now() : null;
  if (began !== null) requestAnimationFrame(step);
});
byId('from').addEventListener('change', chooseStart);
byId('to').addEventListener('change', chooseRoute);
chooseStart();
byId('none').hidden = M.routes.length > 0;
byId('route').hidden = byId('routes').hidden = !M.routes.length;
