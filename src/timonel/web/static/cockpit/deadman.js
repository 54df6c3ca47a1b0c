// @ts-check
/**
 * Who holds the stick, and what the gateway is told about it: a pure machine, told what the hands do.
 *
 * event                                      effect
 * a hand takes hold, its stick at rest       it drives; the others wait until they have let go
 * `tick` while it is held                    the stick is said
 * the hand that drives lets go               a stick at rest is said, and that nobody holds it
 * tab, focus, pad or socket lost; STOP       the same at once, and no hand drives before it took hold anew
 * driving is not allowed any more            the same
 *
 * A hand that was held before driving was allowed does not drive: a permission is no start.
 */

/** @typedef {import("../messages.d.ts").BrowserMessage} BrowserMessage */
/** @typedef {"touch" | "pad" | "keys"} Source */

/**
 * What a source of control says: whether it is held, and the stick -1..1, x to the right, y forward.
 *
 * @typedef {{held: boolean, x: number, y: number}} Hand
 */

/** @type {Readonly<Hand>} */
export const FREE = Object.freeze({held: false, x: 0, y: 0});

/** The wire has whole percents. @param {number} share */
const rounded = (share) => Math.round(share * 1000) / 1000;

/** @typedef {"released" | "hidden" | "blur" | "unplugged" | "socket" | "stop" | "forbidden" | ""} Reason */

export function createDeadman() {
  /** @type {Map<Source, {hand: Hand, armed: boolean}>} `armed`: it may begin, for it has let go since the last loss */
  const hands = new Map();
  /** @type {Source | null} */
  let driver = null;
  let allowed = false;
  /** @type {Reason} */
  let reason = "";
  let count = 0;

  /** What the driver asks for. @returns {Hand} */
  const held = () => (driver === null ? FREE : (hands.get(driver)?.hand ?? FREE));

  /** @param {number | null} seen @returns {BrowserMessage} */
  function stick(seen) {
    const {x, y} = held();
    return {type: "stick", n: ++count, x: rounded(x), y: rounded(y), seen};
  }

  /** @param {Reason} why @param {number | null} seen @returns {BrowserMessage[]} */
  function letGo(why, seen) {
    if (driver === null) return [];
    driver = null;
    reason = why;
    return [stick(seen), {type: "let_go"}];
  }

  return {
    /** Who drives, if anybody. */
    get driver() {
      return driver;
    },
    /** What the driver asks for. */
    get stick() {
      return held();
    },
    /** Why nobody drives any more. */
    get reason() {
      return reason;
    },
    /** Whether some hand is on a stick, be it obeyed or not: then no permission may be asked for. */
    get touched() {
      return [...hands.values()].some(({hand}) => hand.held || hand.x !== 0 || hand.y !== 0);
    },

    /**
     * A source tells what its hand does.
     *
     * @param {Source} source
     * @param {Hand} hand
     * @param {number | null} [seen] the server's clock as it was last heard
     * @returns {BrowserMessage[]} what is to be said
     */
    receive(source, hand, seen = null) {
      const before = hands.get(source);
      const armed = !hand.held || (before !== undefined && before.armed && allowed && (driver === null || driver === source));
      hands.set(source, {hand, armed});
      if (driver === source) return hand.held ? [] : letGo("released", seen);
      if (driver !== null || !hand.held || !armed || hand.x !== 0 || hand.y !== 0) return [];
      driver = source;
      reason = "";
      return [stick(seen)];
    },

    /** Whether driving is allowed: this station is in command and the drives are enabled. @param {boolean} now @param {number | null} [seen] @returns {BrowserMessage[]} */
    allow(now, seen = null) {
      if (now === allowed) return [];
      allowed = now;
      for (const one of hands.values()) one.armed &&= !one.hand.held;
      return now ? [] : letGo("forbidden", seen);
    },

    /** Something is lost without which nobody drives. @param {Reason} why @param {number | null} [seen] @returns {BrowserMessage[]} */
    lose(why, seen = null) {
      for (const one of hands.values()) one.armed = !one.hand.held;
      return letGo(why, seen);
    },

    /** A source is gone: one that comes back has to be seen at rest first. @param {Source} source @param {Reason} why @param {number | null} [seen] @returns {BrowserMessage[]} */
    forget(source, why, seen = null) {
      hands.delete(source);
      return driver === source ? letGo(why, seen) : [];
    },

    /** A stick at rest: a sign of life while nobody drives. @param {number | null} [seen] @returns {BrowserMessage} */
    rest: (seen = null) => stick(seen),

    /** To be called 30 times a second. @param {number | null} [seen] @returns {BrowserMessage[]} */
    tick(seen = null) {
      return driver === null ? [] : [stick(seen)];
    },
  };
}

/** @typedef {ReturnType<typeof createDeadman>} Deadman */
