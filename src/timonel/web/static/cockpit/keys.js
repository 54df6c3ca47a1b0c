// @ts-check
/** WASD and arrows as a stick: a key drives for as long as it is held, and no longer. */

import {FREE} from "./deadman.js";
import {ramped} from "./shaping.js";

/** @typedef {import("./deadman.js").Hand} Hand */

/** @type {Record<string, [x: number, y: number]>} by the place of the key, whatever the keyboard has written on it */
const MOVES = {
  KeyW: [0, 1], ArrowUp: [0, 1], KeyS: [0, -1], ArrowDown: [0, -1],
  KeyA: [-1, 0], ArrowLeft: [-1, 0], KeyD: [1, 0], ArrowRight: [1, 0],
};
const WRITING = "input, select, textarea, [contenteditable]";

/** Whether a key is meant for a field or a dialog. @param {KeyboardEvent} event */
export function elsewhere(event) {
  const target = /** @type {Element | null} */ (event.target instanceof Element ? event.target : null);
  return target?.closest(WRITING) != null || document.querySelector("dialog[open]") !== null;
}

/** What the keys that are held ask for. */
export function createKeys() {
  /** @type {Set<string>} */
  const held = new Set();
  let x = 0;
  let y = 0;
  let begun = false;

  return {
    /** @param {KeyboardEvent} event @returns {boolean} whether it is one of ours */
    down(event) {
      if (event.ctrlKey || event.altKey || event.metaKey) {
        held.clear(); // the system may swallow what comes next
        return false;
      }
      if (!(event.code in MOVES) || elsewhere(event)) return false;
      if (!event.repeat) held.add(event.code); // one that repeats may have been held since before a loss
      return true;
    },
    /** @param {KeyboardEvent} event */
    up(event) {
      held.delete(event.code);
    },
    clear() {
      held.clear();
    },
    /** @param {number} seconds since it was last asked @returns {Hand} */
    step(seconds) {
      if (held.size === 0) {
        x = y = 0;
        begun = false;
        return FREE;
      }
      if (!begun) {
        begun = true;
        return {held: true, x, y}; // a hand takes hold at rest
      }
      const wanted = [...held].reduce(([across, along], code) => [across + MOVES[code][0], along + MOVES[code][1]], [0, 0]);
      x = ramped(x, Math.sign(wanted[0]), seconds);
      y = ramped(y, Math.sign(wanted[1]), seconds);
      return {held: true, x, y};
    },
  };
}
