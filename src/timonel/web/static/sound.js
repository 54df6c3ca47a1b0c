// @ts-check
/** What is heard: a transfer of command, alarms until somebody acknowledges them, warnings now and then. */

/** @typedef {import("./store.js").State} State */
/** @typedef {import("./messages.d.ts").AlertState} AlertState */
/** @typedef {[frequency: number, start: number, length: number]} Tone Hz, s, s */

/** @type {Tone[]} */
const TRANSFER = [[660, 0, 0.9], [880, 1.0, 1.0]]; // two seconds, as ISO 11674's practice has it
/** @type {Tone[]} */
const REQUEST = [[880, 0, 0.12], [880, 0.2, 0.12]];
/** @type {Tone[]} */
const ALARM = [[980, 0, 0.25], [740, 0.25, 0.25]];
/** @type {Tone[]} */
const WARNING = [[740, 0, 0.2], [740, 0.3, 0.2]];
const ALARM_AGAIN = 1.0; // s
const WARNING_AGAIN = 30; // s
const STORED = "timonel.sound";

/** Whether an alert should be heard at `clock`, s of the server. @param {AlertState} alert @param {number} clock */
export function audible(alert, clock) {
  return !alert.acknowledged && alert.priority !== "caution" && (alert.silenced_until === null || alert.silenced_until <= clock);
}

export function createSound() {
  /** @type {AudioContext | null} */
  let context = null;
  let on = localStorage.getItem(STORED) !== "off";
  let commander = -1;
  let asking = 0;
  let alarmDue = 0;
  let warningDue = 0;
  /** @type {Set<string>} */
  let warned = new Set();

  function wake() {
    context ??= new AudioContext();
    if (context.state === "suspended") context.resume();
  }

  /** @param {Tone[]} tones */
  function play(tones) {
    if (!on || context === null || context.state !== "running") return;
    document.dispatchEvent(new CustomEvent("timonel-sound", {detail: tones.length}));
    for (const [frequency, start, length] of tones) {
      const from = context.currentTime + start;
      const gain = new GainNode(context, {gain: 0});
      const tone = new OscillatorNode(context, {frequency, type: "triangle"});
      gain.gain.setTargetAtTime(0.35, from, 0.01);
      gain.gain.setTargetAtTime(0, from + length - 0.04, 0.015);
      tone.connect(gain).connect(context.destination);
      tone.start(from);
      tone.stop(from + length + 0.1);
    }
  }

  /** @param {State} state */
  function command(state) {
    const {command} = state.topics;
    if (!state.live || command === undefined) return;
    const head = command.queue[0]?.station ?? 0;
    if (commander >= 0 && command.commander !== commander) play(TRANSFER);
    else if (head !== 0 && head !== asking) play(REQUEST);
    commander = command.commander;
    asking = head;
  }

  /** @param {State} state @param {number} local */
  function alerts(state, local) {
    const clock = state.clock + (local - state.heard);
    const heard = state.live ? (state.topics.alerts ?? []).filter((alert) => audible(alert, clock)) : [];
    const warnings = new Set(heard.filter((alert) => alert.priority === "warning").map(({id, announced}) => `${id} ${announced}`));
    if (heard.some((alert) => alert.priority === "alarm")) {
      if (local >= alarmDue) {
        play(ALARM);
        alarmDue = local + ALARM_AGAIN;
      }
    } else if (warnings.size > 0 && (local >= warningDue || [...warnings].some((warning) => !warned.has(warning)))) {
      play(WARNING);
      warningDue = local + WARNING_AGAIN;
    }
    warned = warnings;
  }

  for (const gesture of ["pointerdown", "keydown"]) addEventListener(gesture, wake); // browsers are silent before one

  return {
    get on() {
      return on;
    },
    /** Whether the browser lets us be heard yet. */
    get ready() {
      return context?.state === "running";
    },
    /** @param {boolean} wanted */
    turn(wanted) {
      on = wanted;
      localStorage.setItem(STORED, wanted ? "on" : "off");
      if (wanted) play(REQUEST);
    },
    /** @param {State} state @param {number} local */
    draw(state, local) {
      command(state);
      alerts(state, local);
    },
  };
}

/** @typedef {ReturnType<typeof createSound>} Sound */
