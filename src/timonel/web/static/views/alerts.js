// @ts-check
/** Alerts after MSC.302(87): a chip with the most urgent, and the list; flashing until acknowledged, never colour alone. */

import {html, icon, set, setIcon, setText, show} from "../dom.js";
import {t, translated} from "../i18n.js";
import {now} from "../store.js";
import {age} from "../units.js";
import {dialog, open} from "./dialog.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").AlertState} AlertState */

/** The state that IEC 62288 has a symbol for. @param {AlertState} alert @param {number} clock */
export function symbol(alert, clock) {
  if (alert.priority === "caution") return "caution-color-iec";
  if (!alert.active) return `${alert.priority}-rectified-iec`;
  if (alert.acknowledged) return `${alert.priority}-acknowledged-iec`;
  return `${alert.priority}-${alert.silenced_until !== null && alert.silenced_until > clock ? "silenced" : "unacknowledged"}-iec`;
}

/** @param {AlertState} alert */
const name = (alert) => translated("alert", alert.name);

/** @param {Console} console */
function row({socket}) {
  const mark = icon("alerts");
  const title = html("strong");
  const text = html("span", {class: "text"});
  const since = html("span", {class: "since"});
  let id = 0;
  const silence = html("button", {class: "key", type: "button", click: () => socket.ask({type: "silence", alert: id})}, t("alert.silence"));
  const acknowledge = html("button", {class: "key main", type: "button", click: () => socket.ask({type: "acknowledge", alert: id})}, t("alert.acknowledge"));
  const node = html("li", {class: "alert"}, mark, html("div", {class: "words"}, title, text), since, silence, acknowledge);

  /** @param {AlertState} alert @param {number} clock @param {boolean} may */
  function draw(alert, clock, may) {
    id = alert.id;
    setIcon(mark, symbol(alert, clock));
    setText(title, `${t(`priority.${alert.priority}`)}: ${name(alert)}`);
    setText(text, translated("alert_text", alert.text));
    setText(since, age(clock - alert.since));
    set(node, "data-priority", alert.priority);
    set(node, "data-acknowledged", alert.acknowledged);
    show(acknowledge, !alert.acknowledged);
    show(silence, !alert.acknowledged && alert.priority !== "caution");
    acknowledge.disabled = silence.disabled = !may;
  }
  return {node, draw};
}

/** @param {Console} console */
export function alerts(console) {
  const mark = icon("alerts");
  const title = html("span", {class: "title"});
  const count = html("span", {class: "count"});
  const list = html("ul", {class: "alert-list"});
  const none = html("p", {class: "none"}, t("alert.none"));
  const box = dialog("alerts", t("alert.title"), list, none);
  const chip = html("button", {class: "chip", type: "button", "aria-haspopup": "dialog", click: () => open(box)}, mark, title, count);
  const spoken = html("p", {class: "spoken", role: "alert"});
  /** @type {Map<number, ReturnType<typeof row>>} */
  const rows = new Map();

  /** @param {AlertState[]} standing @param {number} clock @param {boolean} may */
  function drawList(standing, clock, may) {
    for (const [id, one] of rows) {
      if (standing.some((alert) => alert.id === id)) continue;
      one.node.remove();
      rows.delete(id);
    }
    standing.forEach((alert, place) => {
      const one = rows.get(alert.id) ?? row(console);
      rows.set(alert.id, one);
      one.draw(alert, clock, may);
      if (list.children[place] !== one.node) list.insertBefore(one.node, list.children[place] ?? null);
    });
  }

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const standing = state.live ? (state.topics.alerts ?? []) : [];
    const clock = now(state, local);
    const first = standing.find((alert) => !alert.acknowledged) ?? standing[0];
    set(chip, "data-priority", first?.priority ?? "none");
    set(chip, "data-acknowledged", first?.acknowledged ?? true);
    setIcon(mark, first === undefined ? "alerts" : symbol(first, clock));
    setText(title, first === undefined ? t("alert.none") : name(first));
    setText(count, standing.length > 1 ? String(standing.length) : "");
    set(chip, "aria-label", `${title.textContent} ${count.textContent}`.trim()); // a small screen has no room for either
    setText(spoken, first === undefined || first.acknowledged ? "" : `${t(`priority.${first.priority}`)}: ${name(first)}`);
    show(none, standing.length === 0);
    if (box.open) drawList(standing, clock, state.you.station !== null);
  }

  return {chip, box, spoken, draw};
}
