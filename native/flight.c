/* The frames of our own recordings, from what a chunk of one holds; see timonel/recording/fast_mcap.py. */
#include "kernels.h"

enum {
    RECORD_HEAD = 9, SIZE = 1, MESSAGE = 5, CHANNEL = 9, STAMP = 15, MESSAGE_HEAD = 31, /* mcap.dev/spec */
    BEFORE_ROWS = 8, LENGTH = 4, FLAGS = 5, DATA = 8, ELAPSED = 16, ROW = 24,           /* recording/flight.py */
    SENT = 1, FRAME = 16
};

/* A row of `bus` becomes a frame and a stamp; false if it is longer than a frame. */
static inline bool one_row(const u8 *row, i64 stamp, u8 *frame, i64 *stamped)
{
    u32 length = row[LENGTH];
    if (length > 8 || row[FLAGS] > SENT)
        return false;
    put_row(frame, load4(row), length, load8(row + DATA));
    *stamped = stamp + (i64)load4(row + ELAPSED) * 1000;
    return true;
}

/* (chunk, at, bus, latest, rows, stamps) -> (how many frames, and where the first record begins that is neither a
   message of another channel than `bus` nor one of frames, all of one row each, from before `latest`). */
PyObject *recorded_frames(PyObject *module, PyObject *arguments)
{
    PyObject *objects[3];
    Py_buffer views[3];
    Buffers buffers;
    long long at, bus, latest;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OLLLOO", &objects[0], &at, &bus, &latest, &objects[1], &objects[2])
        || take_buffers(&buffers, views, objects, 3, 1))
        return NULL;
    const u8 *chunk = views[0].buf;
    u8 *rows = views[1].buf;
    i64 *stamps = views[2].buf, done = 0, end = views[0].len;
    if (at < 0 || at > end)
        PyErr_SetString(PyExc_ValueError, "chunk: a record that is not in it");
    if (PyErr_Occurred() || enough(&views[1], (end - at) / ROW, FRAME, "rows")
        || enough(&views[2], (end - at) / ROW, 8, "stamps")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    while (end - at >= MESSAGE_HEAD && chunk[at] == MESSAGE) {
        u64 size = load8(chunk + at + SIZE);
        if (size > (u64)(end - at - RECORD_HEAD) || size < MESSAGE_HEAD - RECORD_HEAD)
            break;
        if (load2(chunk + at + CHANNEL) == bus) {
            const u8 *row = chunk + at + MESSAGE_HEAD + BEFORE_ROWS, *behind = chunk + at + RECORD_HEAD + size;
            u64 stamp = load8(chunk + at + STAMP);
            i64 found = done;
            if (behind < row || (behind - row) % ROW || stamp >= (u64)latest)
                break;
            while (row < behind && one_row(row, (i64)stamp, rows + FRAME * found, &stamps[found])) {
                row += ROW;
                found++;
            }
            if (row < behind)
                break;
            done = found;
        }
        at += RECORD_HEAD + (i64)size;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    return Py_BuildValue("LL", (long long)done, (long long)at);
}
