// @ts-check
/**
 * From the hands to the gateway: the stick on the screen, the gamepad, the keys, and what makes them let go.
 *
 * While this station is in command and the page is seen, a stick at rest is said ten times a second: that is how the
 * gateway knows that somebody is there. It stops with the page, and the rover with it.
 */

import {inCommand} from "../store.js";
import {createHold} from "./confirming.js";
import {FREE, createDeadman} from "./deadman.js";
import {createKeys, elsewhere} from "./keys.js";
import {createPad} from "./pad.js";

/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").BrowserMessage} BrowserMessage */
/** @typedef {import("./deadman.js").Hand} Hand */
/** @typedef {import("./deadman.js").Reason} Reason */

const PERIOD = 33; // ms: 30 sticks a second
const LIFE = 100; // ms between two signs of life
const BLIND = 500; // ms without news after which nobody sees what he does

/** @param {Console} console */
export function driving({store, socket}) {
  const deadman = createDeadman();
  const keys = createKeys();
  const pad = createPad();
  const hold = createHold(); // of the key or the button that enables
  /** @type {Set<string>} what holds it */
  const holding = new Set();
  let padName = "";
  let padStops = false;
  let last = performance.now();
  let lifeDue = 0;
  let said = 0;

  const seen = () => (store.state.live ? store.state.clock : null);
  const drives = () => inCommand(store.state) && store.state.topics.drive?.permitted === true;

  /** @param {BrowserMessage[]} messages */
  function say(messages) {
    for (const message of messages) {
      if (socket.say(message) && message.type === "stick") said += 1;
    }
    if (messages.length > 0) store.wake();
  }

  /** @param {Reason} why */
  function lose(why) {
    keys.clear();
    holding.clear();
    say(deadman.lose(why, seen()));
  }

  function stop() {
    lose("stop");
    socket.ask({type: "stop"});
  }

  /** The stick must be at rest: a permission is no start. */
  function enable() {
    if (deadman.touched) return false;
    socket.ask({type: "enable"});
    return true;
  }

  /** @param {string} what @param {boolean} held */
  function holdToEnable(what, held) {
    if (held) holding.add(what);
    else holding.delete(what);
  }

  function readPad() {
    const now = pad.read();
    if (now === null) {
      if (padName !== "") {
        padName = "";
        padStops = false;
        holding.delete("pad");
        say(deadman.forget("pad", "unplugged", seen()));
        store.wake();
      }
      return;
    }
    padName = now.name || "gamepad";
    if (now.stop && !padStops) stop();
    padStops = now.stop;
    holdToEnable("pad", now.enable && !drives());
    say(deadman.receive("pad", now.hand, seen()));
  }

  function step() {
    const now = performance.now();
    const {state} = store;
    if (!state.live) lose("socket");
    else if (now - state.heard * 1000 > BLIND && deadman.driver !== null) lose("socket");
    say(deadman.allow(drives() && document.hasFocus(), seen()));
    readPad();
    say(deadman.receive("keys", keys.step((now - last) / 1000), seen()));
    last = now;
    if (deadman.driver !== null) say(deadman.tick(seen()));
    else live(now);
    stepHold(now / 1000);
  }

  /** @param {number} now ms */
  function live(now) {
    if (document.hidden || now < lifeDue || !inCommand(store.state)) return;
    lifeDue = now + LIFE;
    say([deadman.rest(seen())]);
  }

  /** @param {number} now s */
  function stepHold(now) {
    if (holding.size === 0 || drives() || !inCommand(store.state)) {
      if (hold.share(now) > 0) store.wake();
      hold.cancel();
      return;
    }
    hold.press(now);
    store.wake();
    if (hold.done(now)) enable();
  }

  /** @param {KeyboardEvent} event */
  function keyDown(event) {
    const writing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
    if (event.code === "Escape" || (event.code === "Space" && !writing)) {
      if (event.code === "Space") event.preventDefault(); // it presses no button
      if (!event.repeat) stop();
    } else if (event.code === "KeyE" && !elsewhere(event) && !event.ctrlKey && !event.altKey && !event.metaKey) {
      holdToEnable("key", true);
    } else if (keys.down(event) && inCommand(store.state)) event.preventDefault(); // it scrolls nothing
  }

  /** @param {KeyboardEvent} event */
  function keyUp(event) {
    keys.up(event);
    if (event.code === "KeyE") holdToEnable("key", false);
    if (event.code === "Space" && !(event.target instanceof HTMLInputElement)) event.preventDefault();
  }

  /** @type {[EventTarget, string, (event: any) => void][]} */
  const listeners = [
    [document, "keydown", keyDown],
    [document, "keyup", keyUp],
    [document, "visibilitychange", () => document.hidden && lose("hidden")],
    [window, "pagehide", () => lose("hidden")],
    [window, "blur", () => lose("blur")],
    [window, "gamepaddisconnected", readPad],
  ];
  for (const [target, name, listener] of listeners) target.addEventListener(name, listener, true);
  deadman.receive("touch", FREE); // no finger is on the stick yet
  const timer = setInterval(step, PERIOD);

  return {
    deadman,
    stop,
    enable,
    /** The hand on the screen's stick. @param {Hand} hand */
    touch: (hand) => say(deadman.receive("touch", hand, seen())),
    /** Enter, held on the slide. @param {boolean} held */
    enter: (held) => holdToEnable("enter", held),
    /** How far the key that enables is held, 0..1. */
    get held() {
      return hold.share(performance.now() / 1000);
    },
    /** The gamepad, "" if there is none. */
    get pad() {
      return padName;
    },
    /** Sticks that were said so far. */
    get said() {
      return said;
    },
    leave() {
      lose("hidden");
      clearInterval(timer);
      for (const [target, name, listener] of listeners) target.removeEventListener(name, listener, true);
    },
  };
}

/** @typedef {ReturnType<typeof driving>} Driving */
