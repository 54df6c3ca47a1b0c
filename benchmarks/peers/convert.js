// One measured run: frames of a bus to sentences, or sentences to frames, the conversions of Signal K called directly:
// canboatjs, n2k-signalk and signalk-to-nmea0183; nmea0183-signalk and signalk-to-nmea2000. Without the server's streams,
// debouncing and event bus, so in its favour. node convert.js MODULES sentences|frames FILE -> {"messages", "out", "seconds"}
const fs = require('fs')
const path = require('path')
const [modules, wanted, file] = process.argv.slice(2)
const load = name => require(path.join(path.resolve(modules), name))
const { FromPgn, toPgn } = load('@canboat/canboatjs')
const { parseCanId } = load('@canboat/canboatjs/dist/canId')
const { N2kMapper } = load('@signalk/n2k-signalk')

const SENTENCES = ['HDT', 'HDM', 'HDG', 'ROT', 'RSA', 'VHW', 'VLW', 'DPT', 'DBT', 'MTW', 'MWVR', 'MWVT', 'MWD', 'GLL',
  'RMC', 'VTG', 'GGA', 'ZDA', 'XTE', 'RMB', 'APB', 'XDRNA']
const MESSAGES = ['heading', 'trueheading', 'depth', 'speed', 'cogSOG', 'gps', 'wind', 'windTrueWater', 'windTrueGround',
  'seaTemp', 'environmentParameters', 'systemTime', 'attitude', 'navigationdata', 'setdrift']
const app = { debug () {}, error () {}, getSelfPath () {}, getPath () {}, on () {}, emit () {}, selfId: 'self', handleMessage () {} }

function byPath (conversions) {
  const ways = new Map()
  for (const conversion of conversions) {
    for (const key of conversion.keys || []) ways.set(key, [...(ways.get(key) || []), conversion])
  }
  return ways
}

const known = {}

/** What every conversion makes of a delta that has one of its keys. */
function convert (delta, ways, call) {
  let made = 0
  for (const update of (delta && delta.updates) || []) {
    for (const { path: key, value } of update.values || []) {
      known[key] = value
      for (const way of ways.get(key) || []) {
        try {
          if (way.keys.some((name, index) => known[name] === undefined && !(way.defaults && index in way.defaults))) continue
          made += call(way, way.keys.map((name, index) => known[name] === undefined ? way.defaults[index] : known[name]))
        } catch { /* a value that it cannot write */ }
      }
    }
  }
  return made
}

function toSentences () {
  const bytes = fs.readFileSync(file)
  const parser = new FromPgn({ useCamel: true })
  const mapper = new N2kMapper({})
  for (const part of [parser, mapper]) part.on('error', () => {})
  parser.on('warning', () => {})
  const encoder = name => { try { return load(`@signalk/signalk-to-nmea0183/dist/sentences/${name}.js`).default(app) } catch { return null } }
  const ways = byPath(SENTENCES.map(encoder).filter(Boolean))
  let out = 0
  for (let start = 0; start < bytes.length; start += 16) {
    const data = bytes.subarray(start + 8, start + 8 + bytes[start + 4])
    const pgn = parseCanId(bytes.readUInt32LE(start) & 0x1fffffff)
    const message = parser.parsePgnData(pgn, data.length, data, false)
    if (message) out += convert(mapper.toDelta(message), ways, (way, values) => way.f(...values) ? 1 : 0)
  }
  return [bytes.length / 16, out]
}

function toFrames () {
  const lines = fs.readFileSync(file, 'latin1').split('\n').filter(line => line)
  const Parser = load('@signalk/nmea0183-signalk')
  const parser = new (Parser.default || Parser)()
  const conversion = name => { try { return load(`signalk-to-nmea2000/conversions/${name}.js`)(app, {}) } catch { return null } }
  const ways = byPath(MESSAGES.map(conversion).flat().filter(way => way && way.callback))
  let out = 0
  for (const line of lines) {
    let delta
    try { delta = parser.parse(line) } catch { continue }
    out += convert(delta, ways, (way, values) => {
      let made = 0
      for (const message of way.callback(...values) || []) { if (toPgn({ prio: 2, dst: 255, ...message })) made += 1 }
      return made
    })
  }
  return [lines.length, out]
}

const began = process.cpuUsage()
const [messages, out] = wanted === 'sentences' ? toSentences() : toFrames()
const { user, system } = process.cpuUsage(began)
console.log(JSON.stringify({ messages, out, seconds: (user + system) / 1e6 }))
