// @ts-check
/** Enabling the drives: a thumb slid to the end and let go there, or E, Enter or Start held; and why they stand. */

import {html, icon, set, setIcon, setText} from "../dom.js";
import {t, translated} from "../i18n.js";
import {inCommand} from "../store.js";
import {createSlide} from "./confirming.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("./driving.js").Driving} Driving */

const TOLD = 6; // s that a refusal stays to be read

/** @param {Driving} driving */
export function permission(driving) {
  const slide = createSlide();
  const picture = icon("command-locked");
  const thumb = html("span", {class: "thumb", "aria-hidden": "true"}, "»");
  const fill = html("span", {class: "fill", "aria-hidden": "true"});
  const label = html("span", {class: "label"});
  const track = html("button", {class: "slide", type: "button"}, fill, label, thumb);
  const word = html("strong");
  const reason = html("span", {class: "reason"});
  const node = html("section", {class: "panel permission", "aria-label": t("drives.title")},
    html("p", {class: "state", role: "status"}, picture, word, reason), track);
  let refused = -Infinity;
  /** @type {number | null} */
  let finger = null;

  /** @param {PointerEvent} event */
  const place = (event) => event.clientX - track.getBoundingClientRect().left;

  /** @param {PointerEvent} event */
  function press(event) {
    if (track.dataset.state !== "ready" || finger !== null || !slide.press(place(event), thumb.offsetLeft + thumb.offsetWidth)) return;
    finger = event.pointerId;
    track.setPointerCapture(finger);
  }

  /** @param {PointerEvent} event */
  function move(event) {
    if (event.pointerId !== finger) return;
    slide.move(place(event), track.clientWidth - thumb.offsetWidth - 2 * thumb.offsetLeft);
    drawThumb();
  }

  /** @param {PointerEvent} event */
  function lift(event) {
    if (event.pointerId !== finger) return;
    finger = null;
    if (event.type !== "pointerup") slide.cancel();
    else if (slide.release()) ask();
    drawThumb();
  }

  function ask() {
    if (!driving.enable()) refused = performance.now() / 1000;
  }

  function drawThumb() {
    const share = track.dataset.state === "enabled" ? 1 : Math.max(slide.share, driving.held);
    thumb.style.setProperty("--share", share.toFixed(3));
    fill.style.setProperty("--share", share.toFixed(3));
  }

  for (const [name, listener] of /** @type {const} */ ([["pointerdown", press], ["pointermove", move], ["pointerup", lift], ["pointercancel", lift], ["lostpointercapture", lift]])) {
    track.addEventListener(name, listener);
  }
  track.addEventListener("keydown", (event) => event.key === "Enter" && driving.enter(true));
  track.addEventListener("keyup", (event) => event.key === "Enter" && driving.enter(false));
  track.addEventListener("blur", () => driving.enter(false));

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const drive = state.topics.drive;
    const ours = inCommand(state);
    const permitted = state.live && drive?.permitted === true;
    set(node, "data-permitted", permitted);
    setIcon(picture, permitted ? "check-google" : "command-locked");
    setText(word, !state.live ? t("link.lost") : t(permitted ? "drives.enabled" : "drives.stopped"));
    const order = state.orders.find((one) => one.what === "enable");
    const against = order !== undefined && local - order.at < TOLD && (order.outcome === "refused" || order.outcome === "unconfirmed") ? order : null;
    const told = local - refused < TOLD ? t("drives.let_go_first")
      : against !== null ? `${t(`outcome.${against.outcome}`)}${against.reason ? `: ${translated("reason", against.reason)}` : ""}`
      : state.live && drive !== undefined ? why(state, drive.reason) : "";
    setText(reason, told);
    const now = permitted ? "enabled" : ours ? "ready" : "locked";
    set(track, "data-state", now);
    set(track, "aria-disabled", String(now !== "ready"));
    setText(thumb, now === "enabled" ? "✓" : "»");
    setText(label, t(now === "ready" ? "drives.slide" : now === "enabled" ? "drives.enabled_hint" : "drives.not_in_command"));
    set(track, "aria-label", t(now === "ready" ? "drives.slide_long" : now === "enabled" ? "drives.enabled_hint" : "drives.not_in_command"));
    if (now !== "ready") slide.cancel();
    drawThumb();
  }

  return {node, draw};
}

/** Why they are permitted, or stand: a station by its name. @param {State} state @param {string} reason */
function why(state, reason) {
  const number = /^station (\d)$/.exec(reason)?.[1];
  const name = state.topics.command?.stations.find((one) => String(one.id) === number)?.name;
  return name === undefined ? translated("reason", reason) : t("drives.by", {name});
}
