// @ts-check
/** Who has command, who asks for it and how long the commander may still answer; the same on every station. */

import {html, icon, set, setIcon, setText, show, svg} from "../dom.js";
import {t, translated} from "../i18n.js";
import {inCommand, now} from "../store.js";
import {age} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").CommandVerb} CommandVerb */
/** @typedef {{verb: CommandVerb, label: string, main: boolean, enabled: boolean}} Choice */

const BRIDGE = 1;
const REQUEST_TIME = 10; // s of a whole ring
const GUARD = 700; // ms after a change in which nobody can have meant the button that is new there
const AROUND = 2 * Math.PI * 16;

/** What this station may say about command now; the first is the likeliest. @param {State} state @returns {Choice[]} */
export function choices(state) {
  const command = state.topics.command;
  const station = state.you.station;
  if (!state.live || station === null || command === undefined) return [];
  const asked = command.queue.length > 0;
  if (inCommand(state)) {
    const deny = {verb: /** @type {const} */ ("DENYCMD"), label: "command.deny", main: false, enabled: true};
    const yield_ = {verb: /** @type {CommandVerb} */ (asked ? "ACKCMD" : "RELCMD"), label: "command.yield", main: asked, enabled: true};
    return asked ? [yield_, deny] : [yield_];
  }
  const waits = command.queue.some((one) => one.station === station);
  const request = {verb: /** @type {const} */ ("REQCMD"), label: waits ? "command.asked" : "command.request", main: false, enabled: !waits};
  if (station === BRIDGE) return [{verb: "TAKECMD", label: "command.take", main: true, enabled: true}, ...(command.commander ? [request] : [])];
  return [{...request, label: command.commander ? request.label : "command.take", main: true}];
}

function ring() {
  const arc = svg("circle", {class: "left", r: 16, "stroke-dasharray": AROUND.toFixed(2), transform: "rotate(-90)"});
  const number = svg("text", {});
  const node = svg("svg", {class: "ring-of-seconds", viewBox: "-20 -20 40 40", "aria-hidden": "true"}, svg("circle", {class: "whole", r: 16}), arc, number);
  /** @param {number} seconds */
  function draw(seconds) {
    set(arc, "stroke-dashoffset", (AROUND * (1 - Math.min(1, seconds / REQUEST_TIME))).toFixed(1));
    setText(number, String(Math.ceil(seconds)));
  }
  return {node, draw};
}

/** @param {Console} console */
export function commandBar({store, socket}) {
  const badgeIcon = icon("command-no");
  const name = html("strong", {class: "name"});
  const says = html("span", {class: "says"});
  const line = html("span", {class: "line"});
  const seconds = ring();
  const asks = html("span", {class: "asks"});
  const asksShort = html("span", {class: "asks-short"}); // for where there is no room for `asks`
  const spoken = html("p", {class: "spoken", role: "status"});
  const request = html("div", {class: "request"}, seconds.node, asks);
  const badge = html("div", {class: "badge"}, badgeIcon, html("div", {class: "who"}, html("div", {class: "first"}, name, says, asksShort), line));
  const slots = [0, 1].map((place) => html("button", {class: "key command-key", type: "button", "data-slot": place, click: () => press(place)}));
  const node = html("section", {class: "command-bar", "aria-label": t("command.title")}, badge, request, html("div", {class: "slots"}, ...slots), spoken);
  let meaning = "";
  let since = 0;

  /** @param {number} place */
  function press(place) {
    const choice = choices(store.state)[place];
    if (choice?.enabled && performance.now() - since > GUARD) socket.ask({type: "command", verb: choice.verb}, choice.verb);
  }

  /** @param {State} state */
  function drawSlots(state) {
    const offered = choices(state);
    const now_ = offered.map((one) => one.label).join();
    if (now_ !== meaning) {
      since = meaning === "" ? -Infinity : performance.now();
      meaning = now_;
    }
    slots.forEach((slot, place) => {
      const choice = offered[place];
      set(slot, "data-empty", choice === undefined);
      slot.disabled = choice === undefined || !choice.enabled;
      setText(slot, choice === undefined ? "" : t(choice.label));
      set(slot, "data-verb", choice?.verb ?? null);
      set(slot, "data-main", choice?.main ?? false);
    });
  }

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const command = state.topics.command;
    const ours = inCommand(state);
    const kind = !state.live || command === undefined ? "lost" : ours ? "ours" : command.commander ? "other" : "nobody";
    set(node, "data-command", kind);
    setIcon(badgeIcon, {lost: "command-no", ours: "command-in", other: "command-locked", nobody: "command-available"}[kind]);
    const last = state.topics.events?.findLast((one) => one.kind === "command");
    setText(name, {lost: t("link.lost"), nobody: t("command.nobody"), ours: command?.commander_name ?? "", other: command?.commander_name ?? ""}[kind]);
    setText(says, {lost: "", nobody: "", ours: t("command.ours"), other: t("command.has")}[kind]);
    setText(line, kind === "lost" || last === undefined ? "" : `${translated("event", last.text)} · ${age(now(state, local) - last.at)}`);
    const head = state.live ? command?.queue[0] : undefined;
    const left = command?.deadline == null ? null : Math.max(0, command.deadline - now(state, local));
    set(node, "data-asked", head !== undefined);
    setText(asksShort, head === undefined ? "" : t("command.asks_short", {name: head.name}));
    show(request, head !== undefined && left !== null);
    if (head !== undefined && left !== null) {
      seconds.draw(left);
      const more = (command?.queue.length ?? 1) - 1;
      setText(asks, t("command.asks", {name: head.name}) + (more ? ` +${more}` : ""));
    }
    setText(spoken, `${name.textContent} ${says.textContent}. ${head === undefined ? "" : asks.textContent}`);
    drawSlots(state);
  }

  return {node, draw};
}
