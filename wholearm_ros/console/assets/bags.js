// Bags: record, list, replay in this page, report in another one.
function makeBags(link) {
  let recording = false, run = null, draw = null, began = null, names = {}, colours = {};
  byId('record').addEventListener('click', async () => {
    const answer = await link.send({type: 'record', on: !recording});
    byId('record-text').textContent = answer.message;
    list();
  });
  link.on('recording', message => {
    recording = Boolean(message.bag);
    byId('record').textContent = recording ? 'End the recording' : 'Record';
    if (recording) byId('record-text').textContent = `recording into ${message.bag}`;
  });

  async function list() {
    const answer = await link.send({type: 'files'});
    if (!answer.ok) return;
    byId('bag-rows').replaceChildren();
    answer.bags.forEach(bag => {
      const row = element(byId('bag-rows'), 'tr');
      element(row, 'td', bag.name);
      element(row, 'td', `${bag.seconds === null ? '?' : bag.seconds.toFixed(1)} s, ${(bag.bytes / 1e6).toFixed(1)} MB`);
      const cell = element(row, 'td'), play = element(cell, 'button', 'Replay', {type: 'button', 'aria-label': `Replay ${bag.name}`});
      play.addEventListener('click', () => replay(bag.name));
      cell.append(' ');
      element(cell, 'a', 'Report', {href: `bags/${encodeURIComponent(bag.name)}`, target: '_blank', rel: 'noopener'});
    });
    if (!answer.bags.length) element(element(byId('bag-rows'), 'tr'), 'td', 'no bag yet');
  }

  async function replay(name) {
    byId('replay-title').textContent = `reading ${name} …`;
    const answer = await link.send({type: 'replay', bag: name});
    byId('replay-title').textContent = answer.ok ? `Replay of ${name}` : answer.message;
    if (!answer.ok) return;
    run = answer.run;
    ({names, colours} = run);
    draw = makeRunScene(byId('replay-scene'), run);
    const slider = byId('replay-time');
    Object.assign(slider, {min: run.times[0], max: run.times[run.times.length - 1], step: 0.01, disabled: false});
    byId('replay-play').disabled = false;
    show(run.times[0]);
    play();
  }
  function show(t) {
    const T = run.times, last = T.length - 1;
    let k = T.findIndex(v => v > t) - 1;
    if (k < 0) k = t <= T[0] ? 0 : last;
    draw(k, k < last ? Math.max(0, (t - T[k]) / (T[k + 1] - T[k])) : 0);
    byId('replay-time').value = t;
    byId('replay-mode').textContent = names[run.modes[k]] || run.modes[k];
    byId('replay-mode').style.background = colours[run.modes[k]];
    byId('replay-clock').textContent = `${t.toFixed(2)} of ${T[last].toFixed(2)} s`;
  }
  function play() {
    const end = run.times[run.times.length - 1], from = +byId('replay-time').value;
    began = performance.now() - 1000 * (from >= end ? run.times[0] : from);
    byId('replay-play').textContent = 'Pause';
    requestAnimationFrame(step);
  }
  function pause() { began = null; byId('replay-play').textContent = 'Play'; }
  function step(stamp) {
    if (began === null) return;
    const t = (stamp - began) / 1000, end = run.times[run.times.length - 1];
    show(Math.min(Math.max(t, run.times[0]), end));
    t < end ? requestAnimationFrame(step) : pause();
  }
  byId('replay-play').addEventListener('click', () => began === null ? play() : pause());
  const STEPS = {ArrowLeft: -0.05, ArrowRight: 0.05, PageDown: -0.5, PageUp: 0.5};  // [s], as in the report
  byId('replay-time').addEventListener('keydown', event => {
    const step = STEPS[event.key], T = run && run.times;
    if (!step || !T) return;
    event.preventDefault();
    pause();
    show(Math.min(Math.max(+byId('replay-time').value + step, T[0]), T[T.length - 1]));
  });
  byId('replay-time').addEventListener('input', () => { pause(); show(+byId('replay-time').value); });
  return {list};
}
