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

// Over a scene: outlines of the object and of the fingers, and the normals of what touches.
function makeOverlay(world, scene) {
  const shown = (element, pose) => {
    element.style.display = pose ? '' : 'none';
    if (pose) element.setAttribute('transform', place(...pose));
  };
  let normals = null;  // made with the first ones, and so over the outlines
  return {
    // A function that moves an outline of the object to a pose, or hides it.
    outline(kind) {
      const element = make(world, 'polygon', {class: kind, points: points(scene.object)});
      return pose => shown(element, pose);
    },
    // The same of both fingers and their angles.
    hand(kind) {
      const elements = scene.fingers.map(f => make(world, 'polygon', {class: kind, points: points(f.outline)}));
      return angles => elements.forEach((e, i) => shown(e, angles && [...scene.fingers[i].axis, angles[i]]));
    },
    // Contacts one after the other: x, y, normal x, normal y.
    touches(list) {
      normals = normals || make(world, 'g', {class: 'normals'});
      normals.replaceChildren();
      for (let i = 0; i < list.length; i += 4) {
        const [x, y, nx, ny] = list.slice(i, i + 4);
        make(normals, 'line', {class: 'normal', x1: x, y1: y, x2: x + 16 * nx, y2: y + 16 * ny});
      }
    },
  };
}

// Draws a run (what run_data.py gives) into `svg`: a function of a row and of the share of the way to the next one.
function makeRunScene(svg, run) {
  const {world, move} = makeScene(svg, run.scene), over = makeOverlay(world, run.scene), last = run.times.length - 1;
  const plannedHand = over.hand('ghost'), planned = over.outline('ghost'), estimate = over.outline('estimate');
  const lerp = (list, k, u) => list[k].map((v, i) => v + u * (list[Math.min(k + 1, last)][i] - v));
  return (k, u) => {
    move(run.pose[k][0] === null ? null : lerp(run.pose, k, u), lerp(run.angles, k, u));
    plannedHand(lerp(run.planned_angles, k, u));
    planned(lerp(run.planned_pose, k, u));
    estimate(run.estimate[k][0] === null ? null : run.estimate[k]);  // it holds until the next one
    over.touches(run.touches[k]);
  };
}
