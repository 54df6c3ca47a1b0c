// @ts-check
/** Whose console this is: choosing a station, pairing with one, and telling others the digits that pair them. */

import {html, icon, set, setText, show} from "../dom.js";
import {t} from "../i18n.js";
import {askPairing, tellCode} from "../session.js";
import {now} from "../store.js";
import {dialog, open} from "./dialog.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */

const STORED = "timonel.station"; // of this tab: after a reconnection it is the same console as before

/** The six digits that the person at the helm reads out. @param {() => void} paired */
function codeForm(paired) {
  const digits = html("input", {id: "pairing-code", inputmode: "numeric", pattern: "[0-9]{6}", maxlength: 6, autocomplete: "one-time-code", required: true});
  const wrong = html("p", {class: "wrong", role: "alert"});
  const node = html("form", {class: "code", hidden: true}, html("label", {for: "pairing-code"}, t("pairing.digits")), digits,
    html("button", {class: "key main", type: "submit"}, t("pairing.pair")), wrong);
  let pairing = 0;

  /** @param {number} station */
  async function ask(station) {
    const outcome = await askPairing(station);
    show(node, true);
    setText(wrong, outcome.ok ? "" : outcome.error);
    if (!outcome.ok) return;
    pairing = outcome.answer.pairing;
    digits.value = "";
    digits.focus();
  }

  node.addEventListener("submit", async (event) => {
    event.preventDefault();
    const outcome = await tellCode(pairing, digits.value);
    setText(wrong, outcome.ok ? "" : outcome.error);
    if (!outcome.ok) return;
    show(node, false);
    paired();
  });
  return {node, ask};
}

/** @param {Console} console */
export function station({socket}) {
  const label = html("span");
  const button = html("button", {class: "key bar-key station", type: "button", "aria-haspopup": "dialog", click: () => open(box)}, icon("user"), label);
  const list = html("div", {class: "choices column"});
  const code = codeForm(() => {
    box.close();
    socket.reconnect();
  });
  const box = dialog("station-choice", t("station.title"), list, code.node);
  let offered = "";
  let chosen = Number(sessionStorage.getItem(STORED)) || null;

  /** @param {number | null} number */
  function choose(number) {
    chosen = number;
    sessionStorage.setItem(STORED, String(number ?? ""));
    socket.ask({type: "choose", station: number});
    box.close();
  }

  /** @param {State} state */
  function draw(state) {
    const stations = state.topics.command?.stations ?? [];
    const own = stations.find((one) => one.id === state.you.station);
    setText(label, own?.name ?? t("station.none"));
    set(button, "aria-label", own ? t("station.is", {name: own.name}) : t("station.looking"));
    const wanted = JSON.stringify([stations.map((one) => [one.id, one.name]), state.you]);
    if (wanted === offered) return;
    offered = wanted;
    if (state.you.station === null && chosen !== null && state.you.may_choose.includes(chosen)) choose(chosen);
    list.replaceChildren(...stations.map((one) => {
      const may = state.you.may_choose.includes(one.id);
      return html("button", {class: "key choice", type: "button", "aria-pressed": String(one.id === state.you.station),
        click: () => (may ? choose(one.id) : code.ask(one.id))}, `${one.id} · ${one.name}`, ...(may ? [] : [html("small", {}, t("pairing.pair"))]));
    }), html("button", {class: "key choice", type: "button", "aria-pressed": String(own === undefined), click: () => choose(null)}, t("station.looking")));
  }

  return {button, box, draw};
}

/** Who wants to be a station; shown to the one in command, who reads out the digits or refuses. @param {Console} console */
export function pairings({socket}) {
  const node = html("section", {class: "pairings", role: "status"});
  let shown = "";

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const waiting = state.pairings.filter((one) => one.deadline > now(state, local));
    const wanted = waiting.map((one) => one.pairing).join();
    if (wanted === shown) return;
    shown = wanted;
    node.replaceChildren(...waiting.map((one) => html("div", {class: "panel pairing"},
      html("span", {}, t("pairing.wants", {name: one.name || one.address, address: one.address, station: one.station_name})),
      html("output", {class: "value"}, `${one.code.slice(0, 3)} ${one.code.slice(3)}`),
      html("button", {class: "key", type: "button", click: () => socket.ask({type: "refuse_pairing", pairing: one.pairing})}, t("pairing.refuse")))));
  }

  return {node, draw};
}
