// Hand and object as SVG, in millimetres, y up.
const SVG = 'http://www.w3.org/2000/svg';
function make(parent, tag, attributes) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return parent.appendChild(element);
}
const points = list => list.map(p => p.join(',')).join(' ');
const place = (x, y, angle) => `translate(${x} ${y}) rotate(${angle})`;

// Draws into `svg`; `move` takes the object's pose [mm, mm, degrees] or null, and the joint angles [degrees].
function makeScene(svg, scene) {
  svg.replaceChildren();
  svg.setAttribute('viewBox', scene.box.join(' '));
  const world = make(svg, 'g', {transform: 'scale(1,-1)'});
  make(world, 'polyline', {class: 'palm', points: points(scene.palm)});
  const fingers = scene.fingers.map((f, k) => make(world, 'polygon', {class: 'finger f' + k, points: points(f.outline)}));
  const object = make(world, 'g', {id: 'object'});
  make(object, 'polygon', {class: 'object', points: points(scene.object)});
  make(object, 'path', {class: 'mark', d: `M-3,0H3M0,-3V3M0,0L${scene.object[0].join(',')}`});
  scene.fingers.forEach(f => make(world, 'circle', {class: 'axis', cx: f.axis[0], cy: f.axis[1], r: 2.4}));
  function move(pose, angles) {
    angles.forEach((a, i) => fingers[i].setAttribute('transform', place(...scene.fingers[i].axis, a)));
    object.style.display = pose ? '' : 'none';
    if (pose) object.setAttribute('transform', place(...pose));
  }
  return {world, move};
}
