// Written by scripts/make_types.py from timonel/web/messages.py; do not edit.
/**
 * Everything that is said on the console's socket, `/api/v1/socket`; `static/messages.d.ts` is written from it.
 *
 * ```
 * server -> browser    snapshot, then changes 10 to 20 times a second; answer, pong, pairing, pairing_over
 * browser -> server    command, acknowledge, silence, choose, refuse_pairing, refresh, ping;
 *                      to a rover also stick, let_go, enable, stop, limit
 * ```
 * A `snapshot` holds all topics. `changes` holds those that changed since the message numbered `since`: apply it where
 * that is the last `sequence` that was seen, else say `refresh` and a snapshot comes. A slow reader gets fewer changes,
 * never old ones. Nothing changed for a second: `changes` without topics come, so that silence means a dead link.
 *
 * Values are SI: rad, m, m/s, K, V, A; where it says so degrees of latitude and longitude, rpm. `at` and `clock` are
 * seconds of the server's own clock: the age of a value is `clock` now minus `at`. A `stale` value is the last that was
 * known and is not to be shown as one that holds; null is not available.
 */

export type Quality = "fresh" | "stale" | "absent";
export type Reference = "true" | "magnetic";
export type Role = "reader" | "station" | "admin";
export type Priority = "alarm" | "warning" | "caution";
export type Outcome = "sent" | "confirmed" | "refused" | "unconfirmed";
export type PilotWord = "STANDBY" | "HEADING_HOLD" | "TRACK" | "ALARM" | "";
export type CommandVerb = "REQCMD" | "RELCMD" | "TAKECMD" | "ACKCMD" | "DENYCMD";
export type SteeringVerb = "ENGAGE" | "DISENGAGE" | "SETHEADING" | "PORTONE" | "STBDONE" | "PORTTEN" | "STBDTEN";
export type LinkKind = "bus" | "in" | "out" | "gnss";
export type EventKind = "command" | "pilot" | "drive" | "alert" | "link" | "refused" | "security" | "other";
export type WhichLimit = "power" | "speed" | "current";

/** A measured value, and when it was heard; both null if it never was. */
export interface Measured {
  value: number | null;
  at: number | null;
  quality: Quality;
}

/** A measured direction, rad, 0 to 2 pi. */
export interface Direction {
  value: number | null;
  at: number | null;
  quality: Quality;
  reference: Reference;
}

/** Speed in m/s; the angle in rad, 0 to 2 pi clockwise from the bow. */
export interface Wind {
  speed: number | null;
  angle: number | null;
  at: number | null;
  quality: Quality;
}

/** In degrees, north and east positive. */
export interface Position {
  latitude: number | null;
  longitude: number | null;
  at: number | null;
  quality: Quality;
}

/** A station: whether its wire is connected, null if it has none, and how many consoles are it. */
export interface StationState {
  id: number;
  name: string;
  connected: boolean | null;
  web: number;
}

/** A station that asks for command. */
export interface Waiting {
  station: number;
  name: string;
}

/**
 * Who has command: 0 and "" are nobody.
 *
 * `queue` are those who ask, the first one is asked about; the commander may answer until `deadline`, a time of the
 * server's clock. `policy` is what an unanswered request comes to.
 */
export interface CommandState {
  commander: number;
  commander_name: string;
  stations: StationState[];
  queue: Waiting[];
  deadline: number | null;
  policy: "transfer" | "deny";
}

/** A link, since when it is as it is (`at`), and why. A `gnss` link is connected while there is a fix. */
export interface LinkState {
  name: string;
  kind: LinkKind;
  connected: boolean;
  reason: string;
  at: number | null;
}

/**
 * An alert as all stations see it. Silenced until `silenced_until`, it makes no sound and stays.
 *
 * `announced` is how often it was announced again because nobody acknowledged it.
 */
export interface AlertState {
  id: number;
  name: string;
  text: string;
  priority: Priority;
  active: boolean;
  acknowledged: boolean;
  silenced_until: number | null;
  since: number;
  announced: number;
}

/** Something that happened `times` times in a row, the last time at `at`. */
export interface Happening {
  at: number;
  text: string;
  kind: EventKind;
  times: number;
}

/**
 * Mode and set point (rad) of the autopilot; "" is a mode that is not understood.
 *
 * `pending` is a command that the pilot has not confirmed yet; `setpoint` is null where it is not known, and in
 * STANDBY.
 */
export interface PilotState {
  mode: PilotWord;
  setpoint: number | null;
  reference: Reference;
  pending: boolean;
}

/** The stick as it is obeyed now: x to the right, y forward, -1 to 1. */
export interface StickState {
  x: number;
  y: number;
}

/**
 * What the drives are told: `left` and `right` are set points -1 to 1, `speed_limit` the share of full speed.
 *
 * `reason` is why they are permitted to move, or were stopped.
 */
export interface DriveState {
  permitted: boolean;
  stick: StickState;
  left: number;
  right: number;
  speed_limit: number;
  reason: string;
}

/**
 * One wheel, forward positive: set point -1 to 1, speed in rpm, current in A, temperature in K.
 *
 * `state` is that of its side's motor driver, "running", "stopped", "no supply", "fault", null if it was never told;
 * `quality` and `at` are those of the measured speed.
 */
export interface WheelState {
  side: "left" | "right";
  place: "front" | "middle" | "rear";
  setpoint: number;
  rpm: number | null;
  current: number | null;
  temperature: number | null;
  state: string | null;
  at: number | null;
  quality: Quality;
}

/**
 * Voltages in V, of the whole and of the four cells; temperatures of the six modules in K.
 *
 * `state` is "ok", "under voltage", "over temperature", "over current", null if it was never told.
 */
export interface BatteryState {
  voltage: number | null;
  cells: (number | null)[];
  modules: (number | null)[];
  state: string | null;
  at: number | null;
  quality: Quality;
}

/** x forward, y to the left, z up. */
export interface Vector {
  x: number | null;
  y: number | null;
  z: number | null;
}

/** Specific force in m/s2 (z = +g at rest) and rate of turn in rad/s. */
export interface ImuState {
  acceleration: Vector;
  rate: Vector;
  at: number | null;
  quality: Quality;
}

/** Magnetic heading of a level rover in rad, and flux density in T. */
export interface MagnetometerState {
  heading: number | null;
  strength: number | null;
  at: number | null;
  quality: Quality;
}

/** The limits in their steps, as the commander said them: power and speed 1..20, current 1..200; null: not said. */
export interface LimitsState {
  power: number | null;
  speed: number | null;
  current: number | null;
}

/** A frame of the modules: how often it comes, a second, and when it came last. */
export interface FrameRate {
  id: number;
  name: string;
  rate: number;
  at: number;
}

/** What a station's link carried so far: whole frames, bytes that belong to none, `#` that began none. */
export interface Framing {
  port: string;
  frames: number;
  skipped: number;
  rejected: number;
}

/** How well frames come through; `rejected` frames of the bus were not as declared. Told twice a second. */
export interface LinkQuality {
  frames: FrameRate[];
  rejected: number;
  framing: Framing[];
  dialect: string;
}

/** A signal of an owner's frame; text for a code's name. */
export interface OwnValue {
  name: string;
  unit: string;
  value: number | string | null;
}

/** A frame that the owner declared. */
export interface OwnFrame {
  id: number;
  name: string;
  values: OwnValue[];
  at: number;
  quality: Quality;
}

/**
 * A device on the NMEA 2000 bus; `ours` is the gateway itself. What it has not told is null.
 *
 * `name` is its NAME in hexadecimal digits, `function` what it says that it is, `since` when it was first heard.
 */
export interface DeviceState {
  address: number | null;
  name: string;
  maker: string;
  model: string | null;
  software: string | null;
  serial: string | null;
  function: string;
  instance: number;
  installation: string | null;
  since: number;
  ours: boolean;
}

/** All topics of a boat. Rudder and rate of turn are positive to starboard, variation to the east; utc is in s. */
export interface BoatTopics {
  command: CommandState;
  pilot: PilotState;
  heading: Direction;
  cog: Direction;
  sog: Measured;
  stw: Measured;
  rudder: Measured;
  rate_of_turn: Measured;
  depth: Measured;
  wind_apparent: Wind;
  wind_true: Wind;
  water_temperature: Measured;
  position: Position;
  utc: Measured;
  variation: Measured;
  devices: DeviceState[];
  links: LinkState[];
  alerts: AlertState[];
  events: Happening[];
}

/** All topics of a rover. */
export interface RoverTopics {
  command: CommandState;
  drive: DriveState;
  wheels: WheelState[];
  battery: BatteryState;
  imu: ImuState;
  magnetometer: MagnetometerState;
  gps: Position;
  limits: LimitsState;
  quality: LinkQuality;
  own: OwnFrame[];
  links: LinkState[];
  alerts: AlertState[];
  events: Happening[];
}

/** Who you are here: a role, the station that you command as, and those that you may `choose` to be. */
export interface You {
  role: Role;
  station: number | null;
  may_choose: number[];
}

/** Everything as it stands. */
export interface Snapshot {
  type: "snapshot";
  sequence: number;
  clock: number;
  vehicle: "boat" | "rover";
  name: string;
  you: You;
  topics: BoatTopics | RoverTopics;
}

/** The topics that changed since the message numbered `since`. */
export interface Changes {
  type: "changes";
  since: number;
  sequence: number;
  clock: number;
  topics: Partial<BoatTopics & RoverTopics>;
}

/**
 * What became of the message with this id: `sent` at once, then how it ended; `refused` may come at once.
 *
 * A request for command waits for as long as the commander may answer; all else ends within 2 s.
 */
export interface Answer {
  type: "answer";
  id: number;
  outcome: Outcome;
  reason: string;
}

/** The answer to `ping`. */
export interface Pong {
  type: "pong";
  n: number;
  clock: number;
}

/**
 * Somebody at `address` who calls himself `name` wants to be `station`: tell him the six digits, or refuse.
 *
 * Only the station in command and admins are told.
 */
export interface Pairing {
  type: "pairing";
  pairing: number;
  station: number;
  station_name: string;
  code: string;
  name: string;
  address: string;
  deadline: number;
}

/** A pairing was done, refused or forgotten. */
export interface PairingOver {
  type: "pairing_over";
  pairing: number;
}

/**
 * A word of the `$PARP` family, as the station that you are. `parameter`: SETHEADING's heading, rad.
 *
 * A rover takes those about command: REQCMD, RELCMD, TAKECMD, ACKCMD, DENYCMD.
 */
export interface Command {
  type: "command";
  id: number;
  verb: CommandVerb | SteeringVerb;
  parameter?: number | null;
}

/** Somebody has seen the alert. */
export interface Acknowledge {
  type: "acknowledge";
  id: number;
  alert: number;
}

/** No sound of this alert for 30 s, on any station. */
export interface Silence {
  type: "silence";
  id: number;
  alert: number;
}

/** Be this station from now on, one of `may_choose`; null: just look. A snapshot follows. */
export interface Choose {
  type: "choose";
  id: number;
  station: number | null;
}

/** That one is not to be a station. */
export interface RefusePairing {
  type: "refuse_pairing";
  id: number;
  pairing: number;
}

/** A snapshot, please. */
export interface Refresh {
  type: "refresh";
}

/** A pong, please. */
export interface Ping {
  type: "ping";
  n: number;
}

/**
 * The rover's stick: x to the right, y forward. Say it 20 to 50 times a second while your station is in command,
 * at rest too: it rests after 200 ms without, the drives stop after 500 ms, and command is given up after 2 s.
 *
 * One console of a station holds it, who says it first, until `let_go`. `n` counts up. `seen` is the `clock` of the
 * newest message from the server: a stick whose driver has seen nothing for 500 ms counts as at rest.
 */
export interface Stick {
  type: "stick";
  n: number;
  x: number;
  y: number;
  seen?: number | null;
}

/** Nobody holds the stick any more: it is at rest at once, and another console of the station may take it. */
export interface LetGo {
  type: "let_go";
}

/** Permit the drives to move; the stick must be at rest. */
export interface Enable {
  type: "enable";
  id: number;
}

/** Stop the drives. Any station may. */
export interface Stop {
  type: "stop";
  id: number;
}

/** A limit in its steps: power and speed 1..20, current 1..200. */
export interface Limit {
  type: "limit";
  id: number;
  which: WhichLimit;
  value: number;
}

export type ServerMessage = Snapshot | Changes | Answer | Pong | Pairing | PairingOver;
export type BrowserMessage = Command | Acknowledge | Silence | Choose | RefusePairing | Refresh | Ping | Stick | LetGo | Enable | Stop | Limit;
