// Plots as SVG in the pixels of their box, drawn again when it changes its size; colours are those of page.css.
let patterns = 0;
const tipIn = box => box.appendChild(Object.assign(document.createElement('div'), {className: 'tip', hidden: true}));

// The steps 1, 2 or 5 × 10^n between two values, about `count` of them.
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find(s => s * power >= 0.999 * raw);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; k++) list.push(+(k * step).toPrecision(12));
  return list;
}
const label = (parent, x, y, text, anchor, attributes = {}) => {
  make(parent, 'text', {x, y, 'text-anchor': anchor, ...attributes}).textContent = text;
};
const polyline = (xs, ys, x, y) => {  // M after each gap; a gap is a null
  let path = '', pen = 'M';
  xs.forEach((v, i) => {
    if (ys[i] === null || ys[i] === undefined) { pen = 'M'; return; }
    path += `${pen}${x(v).toFixed(1)},${y(ys[i]).toFixed(1)}`;
    pen = 'L';
  });
  return path;
};
function extent(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) for (const v of list) if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
  if (low > high) return [0, 1];
  const room = 0.06 * (high - low) || 0.5;
  return [low - room, high + room];
}
function redrawOnResize(svg, draw) {  // not while it has no size
  let width = 0;
  new ResizeObserver(() => { if (svg.clientWidth && svg.clientWidth !== width) { width = svg.clientWidth; draw(); } }).observe(svg);
}
function legend(box, entries) {
  const line = document.createElement('p');
  line.className = 'legend';
  entries.forEach(({name, kind, colour: ink}) => {
    const entry = line.appendChild(document.createElement('span'));
    const sample = Object.assign(entry.appendChild(document.createElement('i')), {className: kind || ''});
    if (ink) sample.style.background = ink;
    entry.append(name);
  });
  box.append(line);
}
function beside(tip, box, x, y) {  // the tip stays inside its box
  tip.hidden = false;
  const left = x + 14 + tip.offsetWidth > box.clientWidth ? x - 14 - tip.offsetWidth : x + 14;
  Object.assign(tip.style, {left: Math.max(0, left) + 'px', top: Math.max(0, y) + 'px'});
}

// Lines over a common x, panels one above the other. x: sorted; spans: [from, to, colour] behind all; panels: {title, share of the
// height, range or none, note, lines: [{name, kind, y}], region: {low, high} or none}; pick: what a press calls with x, or none.
// Returns a function that moves the cursor.
function makeLines(box, {x: xs, title, panels, spans = [], entries = [], pick}) {
  legend(box, entries);
  const svg = make(box, 'svg', {class: 'lines', role: 'img', 'aria-label': panels.map(p => p.title).join(', ')});
  const tip = tipIn(box), LEFT = 46, RIGHT = 6, TOP = 6, GAP = 16, BOTTOM = 34, first = xs[0], end = xs[xs.length - 1];
  let at = first, cursor = null, hair = null, x = null, back = null;
  function draw() {
    svg.replaceChildren();
    const width = svg.clientWidth, height = svg.clientHeight, free = height - TOP - BOTTOM - GAP * (panels.length - 1);
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    x = v => LEFT + (width - LEFT - RIGHT) * (v - first) / (end - first);
    back = pixel => Math.min(Math.max(first + (pixel - LEFT) / (width - LEFT - RIGHT) * (end - first), first), end);
    let top = TOP;
    panels.forEach(panel => { top += drawPanel(panel, top, free * panel.share, width) + GAP; });
    const bottom = height - BOTTOM;
    ticks(first, end, width / 90).forEach(v => label(svg, x(v), bottom + 15, String(v), 'middle'));
    label(svg, (LEFT + width - RIGHT) / 2, height - 4, title, 'middle');
    hair = make(svg, 'line', {class: 'hair', y1: TOP, y2: bottom, visibility: 'hidden'});
    cursor = make(svg, 'line', {class: 'cursor', y1: TOP, y2: bottom});
    moveTo(at);
  }
  function drawPanel(panel, top, height, width) {
    const [low, high] = panel.range || extent(panel.lines.map(line => line.y)), y = v => top + height * (high - v) / (high - low);
    const id = `plot-${patterns++}`, frame = {x: LEFT, y: top, width: width - LEFT - RIGHT, height};
    make(make(svg, 'clipPath', {id}), 'rect', frame);
    const inside = make(svg, 'g', {'clip-path': `url(#${id})`});
    spans.forEach(([a, b, ink]) => make(inside, 'rect', {x: x(a), y: top, width: Math.max(x(b) - x(a), 0), height, fill: ink, class: 'span'}));
    ticks(low, high, height / 34).forEach(v => {
      make(svg, 'line', {class: 'grid', x1: LEFT, x2: width - RIGHT, y1: y(v), y2: y(v)});
      label(svg, LEFT - 5, y(v) + 4, String(v).replace('-', '−'), 'end');
    });
    if (panel.region) drawRegion(inside, panel.region, y, id);
    panel.lines.forEach(line => make(inside, 'path', {class: 'line ' + line.kind, d: polyline(xs, line.y, x, y)}));
    make(svg, 'rect', {class: 'frame', ...frame});
    label(svg, 11, top + height / 2, panel.title, 'middle', {transform: `rotate(-90 11 ${top + height / 2})`});
    if (panel.note) label(svg, width - RIGHT - 4, top + 13, panel.note, 'end', {class: 'note'});
    return height;
  }
  function drawRegion(parent, {low, high}, y, id) {
    const hatch = make(svg, 'pattern', {id: id + '-hatch', width: 7, height: 7, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)'});
    make(hatch, 'line', {class: 'hatch', x1: 0, x2: 0, y1: 0, y2: 7});
    let begin = null, path = '';
    for (let i = 0; i <= xs.length; i++) {
      const there = i < xs.length && low[i] !== null;
      if (there && begin === null) begin = i;
      if (there || begin === null) continue;
      const up = xs.slice(begin, i), top = high.slice(begin, i), down = up.slice().reverse(), foot = low.slice(begin, i).reverse();
      path += polyline([...up, ...down], [...top, ...foot], x, y) + 'Z';
      begin = null;
    }
    make(parent, 'path', {class: 'region', d: path, fill: `url(#${id}-hatch)`});
  }
  function moveTo(value) {
    at = value;
    if (!cursor) return;
    cursor.dataset.at = value;
    cursor.setAttribute('x1', x(value));
    cursor.setAttribute('x2', x(value));
  }
  const of = event => event.clientX - svg.getBoundingClientRect().left;
  svg.addEventListener('pointermove', event => {
    if (!x) return;
    const value = back(of(event)), k = nearest(xs, value);
    hair.setAttribute('visibility', 'visible');
    ['x1', 'x2'].forEach(name => hair.setAttribute(name, x(xs[k])));
    tip.textContent = [`${title} ${xs[k].toFixed(2)}`, ...panels.map(panel => `${panel.title}: ` + panel.lines.filter(line => line.y[k] !== null)
      .map(line => `${line.name} ${line.y[k].toFixed(3)}`).join(', '))].join('\n');
    beside(tip, box, x(xs[k]), svg.offsetTop + 8);
  });
  svg.addEventListener('pointerleave', () => { tip.hidden = true; if (hair) hair.setAttribute('visibility', 'hidden'); });
  if (pick) svg.addEventListener('click', event => pick(xs[nearest(xs, back(of(event)))]));
  redrawOnResize(svg, draw);
  return moveTo;
}
function nearest(sorted, value) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (sorted[middle] <= value) low = middle; else high = middle; }
  return value - sorted[low] <= sorted[high] - value ? low : high;
}

// Bars one beside the other. bars: {name, parts: [number, of each of `kinds`]}; kinds: {name, colour}; pick: called with a bar's index.
function makeBars(box, {bars, kinds, title, pick}) {
  legend(box, kinds);
  const svg = make(box, 'svg', {class: 'bars', role: 'group', 'aria-label': title});
  const tip = tipIn(box), totals = bars.map(bar => bar.parts.reduce((a, b) => a + b, 0));
  const LEFT = 46, TOP = 6, top = Math.max(...totals, 1e-9) * 1.04;
  function draw() {
    svg.replaceChildren();
    const width = svg.clientWidth, height = svg.clientHeight, one = (width - LEFT) / bars.length, every = Math.ceil(12 / one);
    const longest = Math.max(...bars.map(bar => bar.name.length)), bottom = Math.min(14 + 6.4 * longest, 0.45 * height), foot = height - bottom;
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    const y = v => foot - (foot - TOP) * v / top;
    ticks(0, top, height / 45).forEach(v => {
      make(svg, 'line', {class: 'grid', x1: LEFT, x2: width, y1: y(v), y2: y(v)});
      label(svg, LEFT - 5, y(v) + 4, String(v), 'end');
    });
    label(svg, 11, (TOP + foot) / 2, title, 'middle', {transform: `rotate(-90 11 ${(TOP + foot) / 2})`});
    bars.forEach((bar, k) => {
      const left = LEFT + k * one, group = make(svg, 'g', {class: 'bar', tabindex: 0, role: 'button', 'aria-label': `${bar.name}: ${totals[k].toFixed(2)}`});
      make(group, 'rect', {x: left, y: TOP, width: one, height: foot - TOP, class: 'whole'});
      let sum = 0;
      bar.parts.forEach((part, i) => {
        make(group, 'rect', {x: left + 0.12 * one, width: 0.76 * one, y: y(sum + part), height: y(sum) - y(sum + part), fill: kinds[i].colour});
        sum += part;
      });
      const middle = left + one / 2, shown = bar.name.length * 6.4 + 12 > bottom ? bar.name.slice(0, Math.floor((bottom - 12) / 6.4) - 1) + '…' : bar.name;
      if (k % every === 0) label(svg, middle + 4, foot + 6, shown, 'end', {transform: `rotate(-90 ${middle + 4} ${foot + 6})`, class: 'name'});
      const tell = () => {
        tip.textContent = [bar.name, ...kinds.map((kind, i) => `${kind.name} ${bar.parts[i].toFixed(2)}`), `together ${totals[k].toFixed(2)}`].join('\n');
        beside(tip, box, middle, svg.offsetTop + 8);
      };
      group.addEventListener('pointerenter', tell);
      group.addEventListener('focus', tell);
      ['pointerleave', 'blur'].forEach(name => group.addEventListener(name, () => { tip.hidden = true; }));
      group.addEventListener('click', () => pick(k));
      group.addEventListener('keydown', event => { if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); pick(k); } });
    });
  }
  redrawOnResize(svg, draw);
}

// Shares with their intervals, joined by a line. points: {x, share, low, high, text}, sorted.
function makeShares(box, {points: list, title, xTitle}) {
  const svg = make(box, 'svg', {class: 'shares', role: 'img', 'aria-label': list.map(p => `${xTitle} ${p.x}: ${p.text}`).join(', ')});
  const LEFT = 52, RIGHT = 44, TOP = 16, BOTTOM = 36, lowest = list[0].x, highest = list[list.length - 1].x;
  redrawOnResize(svg, () => {
    svg.replaceChildren();
    const width = svg.clientWidth, height = svg.clientHeight, y = v => height - BOTTOM - (height - TOP - BOTTOM) * v;
    const x = v => LEFT + 14 + (width - LEFT - RIGHT - 14) * (v - lowest) / (highest - lowest);
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    [0, 0.25, 0.5, 0.75, 1].forEach(v => {
      make(svg, 'line', {class: 'grid', x1: LEFT, x2: width - 4, y1: y(v), y2: y(v)});
      label(svg, LEFT - 5, y(v) + 4, `${100 * v} %`, 'end');
    });
    make(svg, 'path', {class: 'line executed', d: polyline(list.map(p => p.x), list.map(p => p.share), x, y)});
    list.forEach(p => {
      make(svg, 'line', {class: 'interval', x1: x(p.x), x2: x(p.x), y1: y(p.low), y2: y(p.high)});
      make(svg, 'circle', {class: 'dot', cx: x(p.x), cy: y(p.share), r: 3.5});
      label(svg, x(p.x) + 7, y(p.share) + 16, p.text, 'start');
      label(svg, x(p.x), height - BOTTOM + 15, String(p.x), 'middle');
    });
    label(svg, (LEFT + width - RIGHT) / 2, height - 4, xTitle, 'middle');
    label(svg, 11, height / 2, title, 'middle', {transform: `rotate(-90 11 ${height / 2})`});
  });
}
