// The connection to the console: messages in by type, commands out with their answers; lost as soon as nothing is heard.
const SILENCE = 1500;  // [ms] the bench says something every 500

function makeLink() {
  const heard = {}, waiting = new Map();
  let socket = null, number = 0, last = 0, alive = false;
  const tell = (type, message) => (heard[type] || []).forEach(hear => hear(message));
  function setAlive(now) {
    if (now === alive) return;
    alive = now;
    if (!alive) {
      waiting.forEach(answer => answer({ok: false, lost: true, message: 'the connection was lost before an answer came'}));
      waiting.clear();
    }
    tell('alive', alive);
  }
  function connect() {
    if (socket) return;
    socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live`);
    const mine = socket;
    last = performance.now();
    mine.onmessage = event => {
      last = performance.now();
      if (mine === socket) setAlive(true);
      const message = JSON.parse(event.data);
      if (message.type === 'answer' && waiting.has(message.id)) {
        waiting.get(message.id)(message);
        waiting.delete(message.id);
      }
      tell(message.type, message);
    };
    mine.onclose = () => {
      if (mine !== socket) return;
      setAlive(false);
      socket = null;
      tell('closed');
    };
  }
  setInterval(() => {
    if (socket && performance.now() - last > SILENCE) {
      setAlive(false);
      if (performance.now() - last > 4 * SILENCE) socket.close();
    }
  }, 200);
  return {
    connect,
    isAlive: () => alive,
    on(type, hear) { (heard[type] = heard[type] || []).push(hear); },
    // A promise of the answer: {ok, message, ...}. Never refused; without a connection ok is false.
    send(message) {
      return new Promise(answer => {
        if (!alive || !socket || socket.readyState !== WebSocket.OPEN) {
          answer({ok: false, lost: true, message: 'no connection: nothing was sent'});
          return;
        }
        number += 1;
        waiting.set(number, answer);
        socket.send(JSON.stringify({...message, id: number}));
      });
    },
  };
}
