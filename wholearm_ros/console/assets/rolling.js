// A plot of the last seconds on a canvas: lines, and a hatched band.
const WINDOW = 10;  // [s]

// lines: [{value: frame => number or null, colour, dash}]; band: frame => [low, high] or null; least: the smallest height of the axis.
function makeRolling(canvas, {lines, band = () => null, least = 1, zero = false}) {
  const frames = [];
  let waiting = false;
  function push(frame) {
    if (frames.length && frame.t < frames[frames.length - 1].t) frames.length = 0;
    frames.push(frame);
    while (frame.t - frames[0].t > WINDOW) frames.shift();
    redraw();
  }
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  }
  function limits() {
    let low = zero ? 0 : Infinity, high = zero ? 0 : -Infinity;
    const take = v => { if (v !== null && v !== undefined) { low = Math.min(low, v); high = Math.max(high, v); } };
    frames.forEach(f => lines.forEach(line => take(line.value(f))));
    if (low > high) [low, high] = [0, least];
    const missing = Math.max(0, least - (high - low)) / 2, room = 0.08 * Math.max(high - low, least);
    return [low - missing - room, high + missing + room];
  }
  function draw() {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const g = canvas.getContext('2d'), left = 40, [low, high] = limits();
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    const end = frames.length ? frames[frames.length - 1].t : 0;
    const x = t => left + (width - left - 4) * (1 - (end - t) / WINDOW), y = v => 4 + (height - 8) * (high - v) / (high - low);
    axis(g, low, high, left, width, y);
    g.save();
    g.beginPath();
    g.rect(left, 0, width - left, height);
    g.clip();
    hatch(g, x, y);
    lines.forEach(line => stroke(g, line, x, y));
    g.restore();
  }
  function axis(g, low, high, left, width, y) {
    const raw = (high - low) / 4, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find(s => s * power >= raw);
    g.font = '11px system-ui, sans-serif';
    g.textAlign = 'right';
    g.textBaseline = 'middle';
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
      g.strokeStyle = colour('line');
      g.lineWidth = Math.abs(v) < step / 2 ? 1.5 : 0.7;
      g.beginPath(); g.moveTo(left, y(v)); g.lineTo(width, y(v)); g.stroke();
      g.fillStyle = colour('soft');
      g.fillText(String(+v.toFixed(6)), left - 6, Math.min(Math.max(y(v), 6), g.canvas.clientHeight - 6));
    }
  }
  function hatch(g, x, y) {
    g.strokeStyle = colour('soft');
    g.lineWidth = 1;
    g.globalAlpha = 0.55;
    frames.forEach((frame, k) => {
      const range = band(frame);
      if (!range || k % 2) return;
      g.beginPath(); g.moveTo(x(frame.t), y(range[0])); g.lineTo(x(frame.t) + 3, y(range[1])); g.stroke();
    });
    g.globalAlpha = 1;
  }
  function stroke(g, line, x, y) {
    g.strokeStyle = colour(line.colour);
    g.lineWidth = line.dash ? 1.6 : 1.8;
    g.setLineDash(line.dash || []);
    g.beginPath();
    let down = false;
    for (const frame of frames) {
      const v = line.value(frame);
      if (v === null || v === undefined) { down = false; continue; }
      down ? g.lineTo(x(frame.t), y(v)) : g.moveTo(x(frame.t), y(v));
      down = true;
    }
    g.stroke();
    g.setLineDash([]);
  }
  dark.addEventListener('change', redraw);
  new ResizeObserver(redraw).observe(canvas);
  return push;
}
