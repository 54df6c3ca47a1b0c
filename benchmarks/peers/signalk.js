// Frames (struct can_frame) on standard input, one sentence each on standard output: canboatjs, n2k-signalk and the
// encoders of signalk-to-nmea0183 called directly. Without the server's streams, debouncing and event bus, so in its favour.
const path = require('path')
const modules = path.resolve(process.argv[2])
const load = name => require(path.join(modules, name))
const { FromPgn } = load('@canboat/canboatjs')
const { parseCanId } = load('@canboat/canboatjs/dist/canId')
const { N2kMapper } = load('@signalk/n2k-signalk')

const app = { debug () {}, getSelfPath () {} }
const encoder = name => load(`@signalk/signalk-to-nmea0183/dist/sentences/${name}.js`).default(app)
const encoders = new Map(Object.entries({
  127250: 'HDT', 127251: 'ROT', 129025: 'GLL', 129026: 'VTG', 128259: 'VHW', 130306: 'MWVR'
}).map(([pgn, name]) => [Number(pgn), encoder(name)]))

const SIZE = 16
const known = { 'navigation.datetime': '2026-01-01T12:00:00.000Z', 'navigation.courseOverGroundMagnetic': 0 }
const parser = new FromPgn({ useCamel: true })
const mapper = new N2kMapper({})
for (const part of [parser, mapper]) part.on('error', () => {})
parser.on('warning', () => {})

function sentence (frame) {
  const data = frame.subarray(8, 8 + frame[4])
  const message = parser.parse({ pgn: parseCanId(frame.readUInt32LE(0) & 0x1fffffff), length: data.length, data })
  if (!message) return
  for (const update of mapper.toDelta(message).updates) for (const { path, value } of update.values) known[path] = value
  const { keys, defaults, f } = encoders.get(message.pgn)
  return f(...keys.map((key, index) => known[key] === undefined && defaults ? defaults[index] : known[key]))
}

let rest = Buffer.alloc(0)
process.stdin.on('data', data => {
  data = Buffer.concat([rest, data])
  let start = 0
  for (; start + SIZE <= data.length; start += SIZE) {
    const text = sentence(data.subarray(start, start + SIZE))
    if (text) process.stdout.write(text + '\r\n')
  }
  rest = data.subarray(start)
})
