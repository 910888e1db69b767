// The hand live: the object as believed, the plan's ghost, the truth where it is told, faces that can be pressed, plots.
const byId = id => document.getElementById(id);
function element(parent, tag, text, attributes = {}) {
  const made = parent.appendChild(document.createElement(tag));
  if (text !== undefined && text !== null) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// `choose` is called with the edge of a face that was pressed.
function makeLive(choose) {
  let parts = null, scene = null, lastPose = null, faces = [], chosen = null;
  const planned = key => frame => frame.g ? frame.g[key] : null;
  const torque = makeRolling(byId('torque-plot'), {least: 0.5, zero: true, band: frame => frame.g ? frame.g.r : null, lines: [
    {value: f => f.q[0], colour: 'left'}, {value: f => f.q[1], colour: 'right'},
    {value: planned('q'), colour: 'planned', dash: [4, 3]}]});
  const angle = makeRolling(byId('angle-plot'), {least: 10, lines: [
    {value: f => f.a[0], colour: 'left'}, {value: f => f.a[1], colour: 'right'},
    {value: f => f.g ? f.g.a[0] : null, colour: 'planned', dash: [4, 3]}, {value: f => f.g ? f.g.a[1] : null, colour: 'planned', dash: [4, 3]}]});

  function setScene(message) {
    scene = message.scene;
    const {world, move} = makeScene(byId('scene'), scene), object = world.querySelector('#object');
    const halo = make(world, 'polygon', {class: 'halo', points: points(scene.object)});
    world.insertBefore(halo, object);
    const over = makeOverlay(world, scene);
    parts = {move, object, halo, hand: over.hand('ghost'), ghost: over.outline('ghost'), truth: over.outline('truth'),
      touches: over.touches, faces: drawFaces(object, message.faces)};
    lastPose = message.pose;
    chosen = null;
    parts.hand(null); parts.ghost(null); parts.truth(null);
    parts.move(message.pose, message.angles);
    parts.object.classList.add('stale');
    parts.halo.style.display = 'none';
    upright(message.pose);
  }
  function drawFaces(object, edges) {
    return edges.map(edge => {
      const a = scene.object[edge], b = scene.object[(edge + 1) % scene.object.length];
      const ends = {x1: a[0], y1: a[1], x2: b[0], y2: b[1]}, middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      const length = Math.hypot(...middle) || 1, inside = middle.map(v => v * (1 - 9 / length));
      const hit = make(object, 'line', {...ends, class: 'face'}), line = make(object, 'line', {...ends, class: 'face-line unknown'});
      const label = make(object, 'text', {class: 'face-label'});
      label.textContent = edge;
      make(hit, 'title', {}).textContent = `edge ${edge}`;
      hit.addEventListener('click', () => choose(edge));
      return {edge, line, label, inside};
    });
  }
  function upright(pose) {
    parts.faces.forEach(f => f.label.setAttribute('transform', `translate(${f.inside}) rotate(${-pose[2]}) scale(1,-1)`));
  }
  function mark() {
    if (!parts) return;
    for (const {edge, line} of parts.faces) {
      const told = faces.find(f => f.edge === edge) || {};
      line.setAttribute('class', 'face-line' + (told.here ? ' here' : told.rate === null ? ' unknown' : '') + (edge === chosen ? ' chosen' : ''));
    }
  }
  function show(frame) {
    if (!parts) return;
    const known = Boolean(frame.e);
    if (known) lastPose = frame.e;
    parts.move(lastPose, frame.a);
    upright(lastPose);
    parts.object.classList.toggle('stale', !known);
    parts.halo.style.display = known ? '' : 'none';
    if (known) {
      parts.halo.setAttribute('transform', place(...frame.e));
      parts.halo.setAttribute('stroke-width', Math.min(4 * frame.d[0], 60));
    }
    byId('believed').textContent = known
      ? `Object: x ${frame.e[0].toFixed(1)} ± ${frame.d[0].toFixed(1)} mm, y ${frame.e[1].toFixed(1)} mm, ${turned(frame.e[2]).toFixed(1)} ± ${frame.d[2].toFixed(1)}°.`
      : 'The fingers do not tell where the object is; it is drawn pale where it was believed last.';
    parts.truth(frame.o || null);
    byId('truth-key').hidden = !frame.o;
    parts.hand(frame.g ? frame.g.a : null);
    parts.ghost(frame.g ? frame.g.p : null);
    parts.touches(frame.n || []);
    torque(frame);
    angle(frame);
  }
  const turned = degrees => degrees - 360 * Math.round(degrees / 360);
  return {
    setScene,
    show,
    setFaces(told) { faces = told; mark(); },
    choose(edge) { chosen = edge; mark(); },
    reset() { if (parts) parts.object.classList.add('stale'); },
  };
}
