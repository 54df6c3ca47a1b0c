// @ts-check
/** The top line of every page: the links' lamps, the time, the alert chip, settings, and whose console this is. */

import {html, set, setText, show} from "../dom.js";
import {t, translated} from "../i18n.js";
import {now, valid} from "../store.js";
import {age, utc} from "../units.js";
import {alerts} from "./alerts.js";
import {dialog, open} from "./dialog.js";
import {settings} from "./settings.js";
import {station} from "./station.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").LinkState} LinkState */
/** @typedef {import("../messages.d.ts").DeviceState} DeviceState */

/** @type {Record<LinkState["kind"], string>} */
const ARROWS = {bus: "", in: "▸", out: "◂", gnss: ""};

/** @param {DeviceState} device */
const row = (device) => html("li", {class: "device"},
  html("strong", {class: "address"}, device.address === null ? t("device.homeless") : String(device.address)),
  html("span", {class: "words"},
    html("span", {}, [device.maker, device.model ?? device.function].filter(Boolean).join(" ") + (device.ours ? ` (${t("device.us")})` : "")),
    html("span", {class: "kind"}, [device.model && device.function, device.software, device.serial, device.installation].filter(Boolean).join(" · "))));

/** Who is on the bus. */
function roll() {
  const title = html("h3", {}, t("device.title"));
  const list = html("ul", {class: "device-list"});
  const node = html("section", {}, title, list);
  /** @type {DeviceState[] | undefined} */
  let drawn;

  /** @param {State} state */
  function draw(state) {
    const devices = state.topics.devices;
    show(node, devices !== undefined);
    if (devices === drawn || devices === undefined) return;
    drawn = devices;
    list.replaceChildren(...(devices.length ? devices.map(row) : [html("li", {class: "device kind"}, t("device.none"))]));
  }
  return {node, draw};
}

/** @param {LinkState} link */
const short = (link) => (link.kind === "bus" ? "CAN" : link.kind === "gnss" ? "GNSS" : link.name);

function lamps() {
  const all = html("span", {class: "lamps", "aria-hidden": "true"});
  const spoken = html("span", {class: "spoken"});
  const list = html("ul", {class: "link-list"});
  const sum = html("span", {class: "sum", "aria-hidden": "true"});
  const devices = roll();
  const box = dialog("links", t("link.title"), list, devices.node);
  const button = html("button", {class: "lamp-button", type: "button", "aria-haspopup": "dialog", click: () => open(box)}, all, sum, spoken);

  /** @param {LinkState[]} links */
  function build(links) {
    all.replaceChildren(...links.map((link) => html("span", {class: "lamp", "data-kind": link.kind, title: link.name},
      html("span", {class: "light"}), html("span", {class: "lamp-name"}, ARROWS[link.kind] + short(link)))));
    list.replaceChildren(...links.map((link) => html("li", {class: "link"},
      html("span", {class: "light"}), html("strong", {}, link.name), html("span", {class: "kind"}, t(`link.${link.kind}`)), html("span", {class: "why"}))));
  }

  let shape = "";
  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const links = state.topics.links ?? [];
    const wanted = links.map((link) => link.kind + link.name).join();
    if (wanted !== shape) build(links);
    shape = wanted;
    const up = links.filter((link) => state.live && link.connected).length;
    set(button, "data-state", !state.live ? "lost" : up === links.length ? "good" : "part");
    setText(sum, state.live ? `${up}/${links.length}` : "-/-");
    setText(spoken, state.live ? t("link.sum", {up, all: links.length}) : t("link.lost"));
    links.forEach((link, place) => {
      const connected = state.live && link.connected;
      for (const where of [all, list]) set(where.children[place], "data-connected", String(connected));
      if (!box.open) return;
      const since = link.at === null ? "" : age(now(state, local) - link.at);
      const why = link.reason ? ` · ${translated("reason", link.reason)}` : "";
      setText(/** @type {Element} */ (list.children[place].lastElementChild), `${t(connected ? "link.up" : "link.down")} ${since}${why}`);
    });
    if (box.open) devices.draw(state);
  }
  return {button, box, draw};
}

/** @param {Console} console */
export function topBar(console) {
  const links = lamps();
  const alert = alerts(console);
  const choose = settings(console);
  const who = station(console);
  const clock = html("output", {class: "utc"});
  const zone = html("span", {class: "unit"}, "UTC");
  const name = html("h1", {class: "spoken"});
  const node = html("header", {class: "top-bar"}, name, links.button,
    html("div", {class: "clock"}, clock, zone), alert.chip, alert.spoken, choose.button, who.button);
  const dialogs = [links.box, alert.box, choose.box, who.box];

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    setText(name, `${state.name} · timonel`);
    links.draw(state, local);
    alert.draw(state, local);
    choose.draw();
    who.draw(state);
    const time = valid(state, state.topics.utc);
    const heard = state.topics.utc?.at ?? 0;
    setText(clock, utc(time === null ? null : time + (now(state, local) - heard)));
  }

  return {node, dialogs, draw};
}
