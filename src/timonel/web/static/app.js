// @ts-check
/** The console: one store, one socket, and the page of the vehicle that is at the other end. */

import {html} from "./dom.js";
import {loadLanguage, t} from "./i18n.js";
import {connect} from "./socket.js";
import {mustSignIn} from "./session.js";
import {createSound} from "./sound.js";
import {createStore} from "./store.js";
import {signInPage} from "./views/sign_in.js";

/**
 * What every view may use.
 *
 * @typedef {object} Console
 * @property {import("./store.js").Store} store
 * @property {import("./socket.js").Socket} socket
 * @property {import("./sound.js").Sound} sound
 * @property {() => void} rebuild draws the page anew, in another language
 */
/** @typedef {{node: HTMLElement, draw: import("./store.js").Draw, leave?: () => void}} Page */

/** @type {Record<"boat" | "rover", (console: Console) => Promise<Page>>} */
const PAGES = {
  boat: async (console) => (await import("./helm.js")).helm(console),
  rover: async (console) => (await import("./cockpit.js")).cockpit(console),
};

const root = /** @type {HTMLElement} */ (document.getElementById("console"));
const store = createStore();
const sound = createSound();
/** @type {string | null} */
let shown = null;
/** @type {() => void} */
let leave = () => {};

async function turnPage() {
  const {vehicle} = store.state;
  if (vehicle === null || vehicle === shown || !store.state.live) return;
  shown = vehicle;
  leave();
  const page = await PAGES[vehicle](console_);
  document.title = `${store.state.name} · timonel`;
  document.documentElement.dataset.vehicle = vehicle;
  root.replaceChildren(page.node);
  const end = store.subscribe(page.draw);
  leave = () => {
    end();
    page.leave?.();
  };
}

async function refused() {
  if (shown === "sign-in" || !(await mustSignIn())) return;
  shown = "sign-in";
  leave();
  root.replaceChildren(signInPage(() => {
    shown = null;
    socket.reconnect();
  }));
}

await loadLanguage();
root.replaceChildren(html("p", {class: "waiting", role: "status"}, t("link.waiting")));
const socket = connect(store, refused);
/** @type {Console} */
const console_ = {store, socket, sound, rebuild: () => {
  shown = null;
  turnPage();
}};
store.subscribe(turnPage);
store.subscribe(sound.draw);
navigator.serviceWorker?.register("sw.js");
