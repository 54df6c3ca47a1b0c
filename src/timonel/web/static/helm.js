// @ts-check
/** The helm of a boat: what its autopilot does, and the keys that steer it. */

import {html, icon, set} from "./dom.js";
import {t} from "./i18n.js";
import {commandBar} from "./views/command_bar.js";
import {compass} from "./views/compass.js";
import {controls, mode} from "./views/controls.js";
import {heading, setpoint, tiles} from "./views/readings.js";
import {rudder} from "./views/rudder.js";
import {pairings} from "./views/station.js";
import {topBar} from "./views/top_bar.js";
import {track} from "./views/track.js";
import {trend} from "./views/trend.js";

/** @typedef {import("./app.js").Console} Console */
/** @typedef {import("./store.js").State} State */

const PANES = {compass: "heading-h-up-proposal", values: "dashboard", trend: "trend", track: "route"};
const STORED = "timonel.pane";

/** Tabs for screens that cannot hold all panes at once. @param {HTMLElement} page */
function tabs(page) {
  const node = html("nav", {class: "tabs", "aria-label": t("tabs.title")});

  /** @param {string} pane */
  function choose(pane) {
    page.dataset.pane = pane;
    sessionStorage.setItem(STORED, pane);
    for (const one of node.children) set(one, "aria-pressed", String(/** @type {HTMLElement} */ (one).dataset.pane === pane));
  }

  node.append(...Object.entries(PANES).map(([pane, picture]) => html("button",
    {class: "tab", type: "button", "data-pane": pane, "aria-label": t(`tabs.${pane}`), click: () => choose(pane)}, icon(picture), html("span", {}, t(`tabs.${pane}`)))));
  const stored = sessionStorage.getItem(STORED);
  choose(stored !== null && stored in PANES ? stored : "compass");
  return node;
}

/** The page, and what draws it. @param {Console} console */
export function helm(console) {
  const page = html("main", {class: "helm"});
  const life = new AbortController();
  const top = topBar(console);
  const command = commandBar(console);
  const keys = controls(console, life.signal);
  const views = [top, command, mode(), heading(), setpoint(), rudder(), tiles(), compass(), trend(life.signal), track(), pairings(console)];
  page.append(...views.map((view) => view.node), tabs(page), keys.turns, keys.auto, keys.standby, ...top.dialogs);

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    for (const view of views) view.draw(state, local);
    keys.draw(state);
  }

  return {node: page, draw, leave: () => life.abort()};
}
