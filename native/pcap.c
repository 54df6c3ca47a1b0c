/* SocketCAN's packets in a capture to frames; see timonel/recording/fast_pcap.py. */
#include "kernels.h"

enum { ROW = 16, SECONDS = 0, FRACTION = 4, CAPTURED = 8, LENGTH = 4, DATA = 8, CAN_PROTOCOL = 12 };

/* Where things stand in a packet: all are of one size, with `frame` bytes before SocketCAN's. */
typedef struct {
    i64 size, captured, frame, protocol; /* protocol: where it stands, or negative */
    i64 nanoseconds;                     /* of a fraction's unit */
    int swapped;                         /* the capture's numbers are of the other byte order */
} Packets;

static inline u32 number(const u8 *at, int swapped)
{
    u32 word = load4(at);
    return swapped ? __builtin_bswap32(word) : word;
}

/* A packet becomes a row and a stamp; false if it is of another kind. */
static inline bool one_packet(const u8 *packet, const Packets *known, u8 *row, i64 *stamp)
{
    const u8 *frame = packet + known->frame;
    u32 identifier = __builtin_bswap32(load4(frame)), length = frame[LENGTH];
    if (number(packet + CAPTURED, known->swapped) != known->captured || length > 8 || identifier & 0x60000000u
        || (!(identifier >> 31) && identifier >> 11))
        return false;
    if (known->protocol >= 0 && (packet[known->protocol] || packet[known->protocol + 1] != CAN_PROTOCOL))
        return false;
    put_row(row, identifier, length, load8(frame + DATA));
    *stamp = (i64)((u64)number(packet + SECONDS, known->swapped) * 1000000000u
                   + (u64)number(packet + FRACTION, known->swapped) * (u64)known->nanoseconds);
    return true;
}

/* (capture, at, count, (size, captured, frame, protocol, nanoseconds, swapped), rows, stamps) -> how many packets from
   `at` on became frames, up to the first of another kind. */
PyObject *captured_frames(PyObject *module, PyObject *arguments)
{
    PyObject *objects[3];
    Py_buffer views[3];
    Buffers buffers;
    long long at, count, size, captured, frame, protocol, nanoseconds, done = 0;
    int swapped;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OLL(LLLLLp)OO", &objects[0], &at, &count, &size, &captured, &frame, &protocol,
                          &nanoseconds, &swapped, &objects[1], &objects[2])
        || take_buffers(&buffers, views, objects, 3, 1))
        return NULL;
    if (at < 0 || frame < 0 || size < 16 || frame > size - ROW || protocol > size - 2 || at > views[0].len || count < 0
        || count > (views[0].len - at) / size)
        PyErr_SetString(PyExc_ValueError, "capture: packets that are not in it");
    if (PyErr_Occurred() || enough(&views[1], count, ROW, "rows") || enough(&views[2], count, 8, "stamps")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    Packets known = {size, captured, frame, protocol, nanoseconds, swapped};
    const u8 *capture = (const u8 *)views[0].buf + at;
    u8 *rows = views[1].buf;
    i64 *stamps = views[2].buf;
    Py_BEGIN_ALLOW_THREADS
    while (done < count && one_packet(capture + size * done, &known, rows + ROW * done, &stamps[done]))
        done++;
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    return PyLong_FromLongLong(done);
}
