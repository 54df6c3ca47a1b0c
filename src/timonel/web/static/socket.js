// @ts-check
/** The one socket: a snapshot, then changes; after a gap a new snapshot, after a loss a new socket within a second. */

/** @typedef {import("./messages.d.ts").ServerMessage} ServerMessage */
/** @typedef {import("./messages.d.ts").BrowserMessage} BrowserMessage */
/** @typedef {import("./store.js").Store} Store */

/**
 * @template T
 * @typedef {T extends {id: number} ? Omit<T, "id"> : never} WithoutId
 */
/** @typedef {WithoutId<BrowserMessage>} Asking */

const SILENCE = 2500; // ms; the server says something every second
const RETRY = [100, 200, 400, 800, 1000]; // ms
const TICK = 250; // ms

/**
 * Keeps a socket to the gateway.
 *
 * @param {Store} store
 * @param {() => void} refused called when there was no way in at all
 */
export function connect(store, refused) {
  /** @type {WebSocket | null} */
  let socket = null;
  let attempts = 0;
  let sequence = -1;
  let ids = 0;
  let heard = 0;
  /** @type {Set<(n: number) => void>} */
  const pongs = new Set();

  function open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const opened = new WebSocket(`${scheme}://${location.host}/api/v1/socket`);
    socket = opened;
    heard = performance.now();
    opened.onmessage = (event) => receive(JSON.parse(event.data));
    opened.onclose = () => closed(opened);
  }

  /** @param {WebSocket} which */
  function closed(which) {
    if (which !== socket) return;
    socket = null;
    if (sequence < 0) refused();
    sequence = -1;
    store.dispatch({type: "lost"});
    setTimeout(open, RETRY[Math.min(attempts++, RETRY.length - 1)]);
  }

  /** @param {ServerMessage} message */
  function receive(message) {
    heard = performance.now();
    attempts = 0;
    if (message.type === "snapshot") sequence = message.sequence;
    if (message.type === "changes") {
      if (sequence < 0) return; // a snapshot is on its way
      if (message.since !== sequence) {
        sequence = -1;
        say({type: "refresh"});
        return;
      }
      sequence = message.sequence;
    }
    if (message.type === "pong") pongs.forEach((pong) => pong(message.n));
    store.dispatch(message);
  }

  /** Says something; false if there is nobody to hear it. @param {BrowserMessage} message */
  function say(message) {
    if (socket?.readyState !== WebSocket.OPEN) return false;
    socket.send(JSON.stringify(message));
    return true;
  }

  /**
   * Asks for something that is answered: what became of it stands in `state.orders`, under the id that is returned.
   *
   * @param {Asking} message
   * @param {string} [what] how the order is called
   */
  function ask(message, what = message.type) {
    const id = ++ids;
    store.dispatch({type: "asked", id, what});
    const told = say(/** @type {BrowserMessage} */ ({...message, id}));
    if (!told) store.dispatch({type: "answer", id, outcome: "unconfirmed", reason: "no connection"});
    return id;
  }

  /** A new socket: what we may do has changed. */
  function reconnect() {
    attempts = 0;
    socket?.close();
  }

  function watch() {
    store.dispatch({type: "tick"});
    if (socket !== null && performance.now() - heard > SILENCE) {
      const silent = socket;
      silent.close();
      closed(silent); // a dead wire takes long to close
    }
  }

  open();
  setInterval(watch, TICK);
  return {say, ask, reconnect, pongs};
}

/** @typedef {ReturnType<typeof connect>} Socket */
