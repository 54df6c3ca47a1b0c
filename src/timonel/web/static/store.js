// @ts-check
/** All that the console knows, and the only place where it changes. */

/** @typedef {import("./messages.d.ts").ServerMessage} ServerMessage */
/** @typedef {import("./messages.d.ts").BoatTopics} BoatTopics */
/** @typedef {import("./messages.d.ts").RoverTopics} RoverTopics */
/** @typedef {import("./messages.d.ts").You} You */
/** @typedef {import("./messages.d.ts").Pairing} Pairing */
/** @typedef {import("./messages.d.ts").Outcome} Outcome */

/**
 * Something that was asked of the gateway, and what became of it: "asked" until the gateway says that it has it.
 *
 * @typedef {object} Order
 * @property {number} id
 * @property {string} what a verb, or the message's type
 * @property {"asked" | Outcome} outcome
 * @property {string} reason
 * @property {number} at
 */

/**
 * `clock` is the server's; `heard` is when it said so, by our own clock: see `now`. Not `live`, nothing that is known
 * is to be shown as if it held.
 *
 * @typedef {object} State
 * @property {boolean} live
 * @property {boolean} met whether there ever was a snapshot
 * @property {number} clock
 * @property {number} heard
 * @property {"boat" | "rover" | null} vehicle
 * @property {string} name
 * @property {You} you
 * @property {Partial<BoatTopics & RoverTopics>} topics
 * @property {Order[]} orders newest first
 * @property {Pairing[]} pairings
 */

/**
 * @typedef {{type: "lost"} | {type: "tick"} | {type: "asked", id: number, what: string}} LocalMessage
 * @typedef {(ServerMessage | LocalMessage) & {now: number}} Message `now` is our own clock, s
 */

const ORDERS_KEPT = 20;
export const ANSWER_TIME = 2.0; // s; what is not confirmed by then is shown as not confirmed

/** @type {State} */
export const NOTHING = {
  live: false, met: false, clock: 0, heard: 0, vehicle: null, name: "",
  you: {role: "reader", station: null, may_choose: []}, topics: {}, orders: [], pairings: [],
};

/** @param {State} state  @param {Message} message  @returns {State} */
export function reduce(state, message) {
  switch (message.type) {
    case "snapshot": {
      const {vehicle, name, you, topics, clock} = message;
      return {...state, live: true, met: true, vehicle, name, you, topics, clock, heard: message.now};
    }
    case "changes":
      return {...state, live: true, topics: {...state.topics, ...message.topics}, clock: message.clock, heard: message.now};
    case "asked":
      return {...state, orders: [order(message), ...state.orders].slice(0, ORDERS_KEPT)};
    case "answer":
      return {...state, orders: state.orders.map((one) => (one.id === message.id ? answered(one, message) : one))};
    case "tick":
      return overdue(state, message.now) ? {...state, orders: state.orders.map((one) => giveUp(one, message.now))} : state;
    case "lost":
      return {...state, live: false, pairings: [], orders: state.orders.map(cutOff)};
    case "pairing":
      return {...state, pairings: [...without(state.pairings, message.pairing), message]};
    case "pairing_over":
      return {...state, pairings: without(state.pairings, message.pairing)};
    case "pong":
      return state;
  }
}

/** The server's clock at `local`, s of our own. @param {State} state @param {number} local */
export const now = (state, local) => state.clock + (local - state.heard);

/**
 * A value if it may be shown as one that holds, else null.
 *
 * @param {State} state
 * @param {{value: number | null, quality: string} | undefined} measured
 */
export function valid(state, measured) {
  return state.live && measured !== undefined && measured.quality === "fresh" ? measured.value : null;
}

/** Whether we are the station in command. @param {State} state */
export function inCommand(state) {
  return state.live && state.you.station !== null && state.topics.command?.commander === state.you.station;
}

/** @param {{id: number, what: string, now: number}} asked @returns {Order} */
const order = ({id, what, now: at}) => ({id, what, outcome: "asked", reason: "", at});

/** @param {Order} one @param {{outcome: Outcome, reason: string}} answer @returns {Order} */
const answered = (one, {outcome, reason}) => ({...one, outcome, reason});

/** Whether it should have been confirmed in time. A request for command takes as long as people do. @param {Order} one */
const open = (one) => one.outcome === "asked" || (one.outcome === "sent" && one.what !== "REQCMD");

/** @param {State} state @param {number} time */
const overdue = (state, time) => state.orders.some((one) => open(one) && time >= one.at + ANSWER_TIME + 0.5);

/** @param {Order} one @param {number} time @returns {Order} */
const giveUp = (one, time) => (open(one) && time >= one.at + ANSWER_TIME + 0.5 ? {...one, outcome: "unconfirmed"} : one);

/** The answer to what was under way will never come. @param {Order} one @returns {Order} */
const cutOff = (one) => (one.outcome === "asked" || one.outcome === "sent" ? {...one, outcome: "unconfirmed"} : one);

/** @param {Pairing[]} pairings @param {number} number */
const without = (pairings, number) => pairings.filter((one) => one.pairing !== number);

/** @typedef {(state: State, local: number) => void} Draw */

/**
 * Keeps the state and calls `draw` at most once a picture of the screen.
 *
 * @param {(message: Message) => void} [watch] sees every message after it was taken in
 */
export function createStore(watch) {
  let state = NOTHING;
  let due = false;
  /** @type {Set<Draw>} */
  const draws = new Set();
  const local = () => performance.now() / 1000;

  function drawAll() {
    due = false;
    for (const draw of draws) draw(state, local());
  }

  function wake() {
    if (due) return;
    due = true;
    if (document.hidden) setTimeout(drawAll, 100);
    else requestAnimationFrame(drawAll);
  }

  return {
    get state() {
      return state;
    },
    /** @param {ServerMessage | LocalMessage} message */
    dispatch(message) {
      const taken = {...message, now: local()};
      state = reduce(state, taken);
      watch?.(taken);
      wake();
    },
    /** Draws now and after every change; returns what ends it. @param {Draw} draw */
    subscribe(draw) {
      draws.add(draw);
      draw(state, local());
      return () => draws.delete(draw);
    },
    wake,
  };
}

/** @typedef {ReturnType<typeof createStore>} Store */
