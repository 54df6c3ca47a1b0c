// @ts-check
/** What steers: STANDBY, AUTO and the four keys. Those of another station's console are locked and say who has command. */

import {html, icon, set, setIcon, setText, show} from "../dom.js";
import {t, translated} from "../i18n.js";
import {inCommand} from "../store.js";
import {inDialog} from "./dialog.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../store.js").Order} Order */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").SteeringVerb} SteeringVerb */

const DOUBLE_TAP = 300; // ms within which a second touch is a mistake
const NEW_COMMAND = 600; // ms after a transfer in which nobody can have meant a key that was locked before
const SHOWN = 6; // s that the outcome of an order stays to be read

/** @type {[SteeringVerb, string, string][]} */
const TURNS = [["PORTTEN", "−10", "port"], ["PORTONE", "−1", "port"], ["STBDONE", "+1", "starboard"], ["STBDTEN", "+10", "starboard"]];
/** @type {Record<string, SteeringVerb>} */
const ARROWS = {ArrowLeft: "PORTONE", ArrowRight: "STBDONE", "Shift+ArrowLeft": "PORTTEN", "Shift+ArrowRight": "STBDTEN"};

/** What steers, from the keys of the page and from the keyboard. @param {Console} console @param {AbortSignal} signal ends it */
export function controls({store, socket}, signal) {
  /** @type {Map<string, number>} */
  const pressed = new Map();
  let commandSince = -Infinity;
  let had = false;

  /** Whether this press is meant: not the second half of a double tap, not just after a transfer. @param {string} verb */
  function meant(verb) {
    const time = performance.now();
    if (time - (pressed.get(verb) ?? -Infinity) < DOUBLE_TAP || time - commandSince < NEW_COMMAND) return false;
    pressed.set(verb, time);
    return true;
  }

  /** @param {SteeringVerb} verb */
  function steer(verb) {
    if (!inCommand(store.state)) return;
    if (verb === "DISENGAGE" || meant(verb)) socket.ask({type: "command", verb}, verb);
  }

  const keys = TURNS.map(([verb, label, side]) => html("button",
    {class: "key turn", type: "button", "data-verb": verb, "data-side": side, "aria-label": `${label} ${t(`order.${verb}_long`)}`, click: () => steer(verb)}, label));
  const lockText = html("strong");
  const lock = html("div", {class: "lock"}, icon("command-locked"), lockText);
  const turns = html("div", {class: "turns", role: "group", "aria-label": t("controls.turns")}, ...keys, lock);
  const auto = html("button", {class: "key auto", type: "button", "data-verb": "ENGAGE", click: () => steer("ENGAGE")}, icon("command-autopilot"), t("order.ENGAGE"));
  const standbyIcon = icon("standby-iec");
  const standby = html("button", {
    class: "key standby", type: "button", "data-verb": "DISENGAGE",
    pointerdown: (/** @type {PointerEvent} */ event) => event.button === 0 && steer("DISENGAGE"), // not when the finger leaves
    click: (/** @type {MouseEvent} */ event) => event.detail === 0 && steer("DISENGAGE"), // from the keyboard
  }, standbyIcon, t("order.DISENGAGE"));

  document.addEventListener("keydown", (event) => {
    if (inDialog() || event.altKey || event.ctrlKey || event.metaKey) return;
    const verb = event.code === "Space" ? "DISENGAGE" : ARROWS[(event.shiftKey ? "Shift+" : "") + event.key];
    if (verb === undefined) return;
    event.preventDefault();
    if (!event.repeat) steer(verb);
  }, {signal});
  document.addEventListener("keyup", (event) => {
    if (event.code === "Space" && !inDialog()) event.preventDefault(); // it pressed no button
  }, {signal});

  /** @param {State} state */
  function draw(state) {
    const ours = inCommand(state);
    if (ours && !had) commandSince = performance.now();
    had = ours;
    for (const key of keys) key.disabled = !ours;
    auto.disabled = !ours || state.topics.pilot?.mode === "ALARM";
    standby.disabled = !ours;
    set(turns, "data-locked", !ours);
    set(auto, "aria-pressed", String(state.live && state.topics.pilot?.mode === "HEADING_HOLD"));
    set(standby, "aria-pressed", String(state.live && state.topics.pilot?.mode === "STANDBY"));
    setIcon(standbyIcon, ours ? "standby-iec" : "command-locked");
    show(lock, !ours);
    setText(lockText, who(state));
  }

  return {turns, auto, standby, draw};
}

/** Why the keys are locked. @param {State} state */
function who(state) {
  if (!state.live) return t("link.lost");
  if (state.you.station === null) return t("station.looking");
  const command = state.topics.command;
  return command?.commander ? `${command.commander_name} ${t("command.has")}` : t("command.nobody");
}

/** What the pilot does, and what became of the last order. */
export function mode() {
  const word = html("strong", {class: "word"});
  const mark = html("span", {class: "mark", "aria-hidden": "true"});
  const text = html("span", {class: "text"});
  const order = html("p", {class: "order", role: "status"}, mark, text);
  const node = html("section", {class: "panel mode", "aria-label": t("mode.title")}, word, order);

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const pilot = state.topics.pilot;
    const name = !state.live || pilot === undefined || pilot.mode === "" ? "unknown" : pilot.mode;
    setText(word, t(`mode.${name}`));
    set(node, "data-mode", name);
    const last = state.orders.find((one) => one.what !== "choose");
    const shown = last !== undefined && local - last.at < (last.outcome === "sent" ? 15 : SHOWN) ? last : null;
    set(order, "data-outcome", shown?.outcome ?? "none");
    setText(mark, shown === null ? "" : MARKS[shown.outcome]);
    setText(text, shown === null ? "" : outcome(shown));
  }

  return {node, draw};
}

/** @type {Record<Order["outcome"], string>} */
const MARKS = {asked: "…", sent: "›", confirmed: "✓", refused: "✕", unconfirmed: "?"};

/** @param {Order} order */
function outcome(order) {
  const what = t(`order.${order.what}`);
  const reason = order.reason ? `: ${translated("reason", order.reason)}` : "";
  return `${what} ${t(`outcome.${order.outcome}`)}${reason}`;
}
