// @ts-check
/** A gamepad: the left stick drives while a shoulder button is held. */

import {shaped} from "./shaping.js";

/** @typedef {import("./deadman.js").Hand} Hand */
/** @typedef {{hand: Hand, stop: boolean, enable: boolean, name: string}} Pad `hand`'s x and y also while it is not held */

const SHOULDERS = [4, 5, 6, 7]; // of the standard mapping: left and right, above and below
const STOPS = [1, 8]; // the right one of the four, and Back
const ENABLES = 9; // Start

/** @param {Gamepad} pad @param {number} button */
const pressed = (pad, button) => pad.buttons[button]?.pressed === true;

/** One pad of those that are plugged in: who is held first, until it is unplugged. */
export function createPad() {
  let index = -1;

  /** @returns {Gamepad | null} */
  function find() {
    const pads = [...navigator.getGamepads()].filter((pad) => pad !== null && pad.connected);
    const ours = pads.find((pad) => pad?.index === index);
    if (ours === undefined) index = -1;
    return ours ?? pads.find((pad) => pad !== null && SHOULDERS.some((button) => pressed(pad, button))) ?? pads[0] ?? null;
  }

  return {
    /** What it says now; null: there is none. @returns {Pad | null} */
    read() {
      const pad = find();
      if (pad === null) return null;
      const held = SHOULDERS.some((button) => pressed(pad, button));
      if (held) index = pad.index;
      const {x, y} = shaped(pad.axes[0] ?? 0, -(pad.axes[1] ?? 0));
      return {hand: {held, x, y}, stop: STOPS.some((button) => pressed(pad, button)), enable: pressed(pad, ENABLES), name: pad.id.replace(/\s*\(.*/, "")};
    },
  };
}
