// @ts-check
/** STOP: never disabled, on every page and over every dialog, in the same place. */

import {html, set, setText, svg} from "../dom.js";
import {t} from "../i18n.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("./driving.js").Driving} Driving */

const SHOWN = 4; // s

/** @type {Record<import("../store.js").Order["outcome"], string>} */
const MARKS = {asked: "…", sent: "›", confirmed: "✓", refused: "✕", unconfirmed: "?"};

/** @param {Driving} driving */
export function stop(driving) {
  const outcome = html("span", {class: "outcome", "aria-hidden": "true"});
  const node = html("button", {
    class: "stop", type: "button", "aria-label": t("stop.long"), "aria-keyshortcuts": "Space Escape",
    pointerdown: (/** @type {PointerEvent} */ event) => event.button === 0 && driving.stop(), // not when the finger leaves
    click: (/** @type {MouseEvent} */ event) => event.detail === 0 && driving.stop(), // from the keyboard
  }, svg("svg", {viewBox: "-12 -12 24 24", "aria-hidden": "true"}, svg("path", {d: "M-4.4 -10.6H4.4L10.6 -4.4V4.4L4.4 10.6H-4.4L-10.6 4.4V-4.4Z"})),
  html("span", {class: "word"}, t("stop.word")), outcome);

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const order = state.orders.find((one) => one.what === "stop");
    const shown = order !== undefined && local - order.at < SHOWN ? order.outcome : null;
    set(node, "data-outcome", shown);
    setText(outcome, shown === null ? "" : `${MARKS[shown]} ${t(`outcome.${shown}`)}`);
  }

  return {node, draw};
}
