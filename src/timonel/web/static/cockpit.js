// @ts-check
/** The cockpit of a rover: what its wheels, battery and sensors say, the stick that drives it, and STOP over all. */

import {battery} from "./cockpit/battery.js";
import {driving} from "./cockpit/driving.js";
import {horizon} from "./cockpit/horizon.js";
import {limits} from "./cockpit/limits.js";
import {permission} from "./cockpit/permission.js";
import {plots} from "./cockpit/plots.js";
import {own, quality} from "./cockpit/quality.js";
import {stick} from "./cockpit/stick.js";
import {stop} from "./cockpit/stop.js";
import {summary} from "./cockpit/summary.js";
import {track} from "./cockpit/track.js";
import {wheels} from "./cockpit/wheels.js";
import {html, set} from "./dom.js";
import {t} from "./i18n.js";
import {commandBar} from "./views/command_bar.js";
import {pairings} from "./views/station.js";
import {topBar} from "./views/top_bar.js";

/** @typedef {import("./app.js").Console} Console */
/** @typedef {import("./store.js").State} State */

const STORED = "timonel.page";
const STYLE = "cockpit.css";

/** The cockpit's own style: a helm has no use for it. */
function styled() {
  if (document.querySelector(`link[href="${STYLE}"]`) !== null) return Promise.resolve();
  return new Promise((done) => document.head.append(html("link", {rel: "stylesheet", href: STYLE, load: done, error: done})));
}

/** Tabs for screens that cannot hold everything at once. @param {HTMLElement} cockpit @param {string[]} all */
function tabs(cockpit, all) {
  const node = html("nav", {class: "pages", "aria-label": t("pages.title")});

  /** @param {string} page */
  function choose(page) {
    cockpit.dataset.page = page;
    sessionStorage.setItem(STORED, page);
    for (const one of node.children) set(one, "aria-pressed", String(/** @type {HTMLElement} */ (one).dataset.page === page));
  }

  node.append(...all.map((page) => html("button", {class: "tab", type: "button", "data-page": page, click: () => choose(page)}, t(`pages.${page}`))));
  const stored = sessionStorage.getItem(STORED);
  choose(stored !== null && all.includes(stored) ? stored : all[0]);
  return node;
}

/** The page, and what draws it. @param {Console} console */
export async function cockpit(console) {
  await styled();
  const drive = driving(console);
  const top = topBar(console);
  const command = commandBar(console);
  const charts = plots();
  const link = quality(console, drive);
  const speed = limits(console, ["speed"], t("limit.speed"));
  speed.node.classList.add("speed-limit");
  const panes = {
    drive: [permission(drive), summary(), speed, stick(drive)],
    rover: [wheels(), horizon(), battery()],
    way: [track()],
    plots: [charts],
    link: [limits(console, ["power", "current"], t("limit.title")), link, own()],
  };
  const stopKey = stop(drive);
  const others = top.dialogs.map((box) => { // a dialog makes deaf what is not in it
    const one = stop(drive);
    box.append(one.node);
    return one;
  });
  const asking = pairings(console);
  const page = html("main", {class: "cockpit"});
  page.append(html("h1", {class: "spoken"}, console.store.state.name), top.node, command.node, tabs(page, Object.keys(panes)), ...Object.entries(panes).map(([name, parts]) =>
    html("div", {class: "pane", "data-page": name, role: "group", "aria-label": t(`pages.${name}`), tabindex: "0"}, ...parts.map((part) => part.node))),
  asking.node, stopKey.node, ...top.dialogs);
  const views = [top, command, asking, ...Object.values(panes).flat(), stopKey, ...others];

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    for (const view of views) view.draw(state, local);
  }

  function leave() {
    drive.leave();
    charts.leave();
    link.leave();
  }

  return {node: page, draw, leave};
}
