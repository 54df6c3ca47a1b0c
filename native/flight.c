/* The frames of our own recordings, from what a chunk of one holds; see timonel/recording/fast_mcap.py. */
#include "kernels.h"

enum {
    RECORD_HEAD = 9, SIZE = 1, MESSAGE = 5, CHANNEL = 9, STAMP = 15, MESSAGE_HEAD = 31, /* mcap.dev/spec */
    CDR_HEAD = 4, COUNT = 4, MOST_DATA = 8,                                             /* recording/flight_bus.py */
    BEFORE_ROWS = 8, LENGTH = 4, FLAGS = 5, DATA = 8, ELAPSED = 16, ROW = 24,
    SENT = 1, FRAME = 16, FEWEST = 17
};

/* The columns of a message: where each begins. */
typedef struct {
    const u8 *identifier, *data, *since, *steps, *length, *flags;
} Columns;

/* Behind a column of `count` numbers of `width` bytes, which begins aligned to 4 bytes behind its count; -1 if it is no
   such one. */
static inline i64 column(const u8 *message, i64 size, i64 at, i64 count, i64 width, const u8 **begin)
{
    at = (at + 3) / 4 * 4 + COUNT;
    if (at > size || load4(message + at - COUNT) != count || count > (size - at) / width)
        return -1;
    *begin = message + at;
    return at + count * width;
}

/* How many frames a message has in columns; -1 if it is not made of them. */
static inline i64 take_columns(const u8 *message, i64 size, Columns *columns)
{
    if (size < CDR_HEAD + COUNT)
        return -1;
    i64 count = load4(message + CDR_HEAD), at = CDR_HEAD;
    if ((at = column(message, size, at, count, 4, &columns->identifier)) < 0
        || (at = column(message, size, at, count * MOST_DATA, 1, &columns->data)) < 0
        || (at = column(message, size, at, count, 2, &columns->since)) < 0
        || (at = column(message, size, at, count, 1, &columns->steps)) < 0
        || (at = column(message, size, at, count, 1, &columns->length)) < 0
        || (at = column(message, size, at, count, 1, &columns->flags)) < 0)
        return -1;
    return at == size ? count : -1;
}

/* The frames of a message in columns; -1 if one of them is longer than a row. */
static inline i64 from_columns(const Columns *columns, i64 count, i64 stamp, u8 *rows, i64 *stamps)
{
    for (i64 each = 0; each < count; each++) {
        u32 length = columns->length[each];
        if (length > MOST_DATA || columns->flags[each] > SENT)
            return -1;
        stamp += 1000 * (i64)load2(columns->since + 2 * each);
        put_row(rows + FRAME * each, load4(columns->identifier + 4 * each), length, load8(columns->data + 8 * each));
        stamps[each] = stamp;
    }
    return count;
}

/* The same of a message with rows. */
static inline i64 from_rows(const u8 *row, i64 count, i64 stamp, u8 *rows, i64 *stamps)
{
    for (i64 each = 0; each < count; each++, row += ROW) {
        u32 length = row[LENGTH];
        if (length > MOST_DATA || row[FLAGS] > SENT)
            return -1;
        put_row(rows + FRAME * each, load4(row), length, load8(row + DATA));
        stamps[each] = stamp + (i64)load4(row + ELAPSED) * 1000;
    }
    return count;
}

/* The frames of a message, of whichever kind it is; -1 if it is of none, or a frame is longer than a row. */
static inline i64 frames_of(const u8 *message, i64 size, i64 stamp, u8 *rows, i64 *stamps)
{
    Columns columns;
    if (size >= BEFORE_ROWS && size - BEFORE_ROWS == ROW * (i64)load4(message + CDR_HEAD))
        return from_rows(message + BEFORE_ROWS, (size - BEFORE_ROWS) / ROW, stamp, rows, stamps);
    i64 count = take_columns(message, size, &columns);
    return count < 0 ? -1 : from_columns(&columns, count, stamp, rows, stamps);
}

/* (chunk, at, bus, latest, rows, stamps) -> (how many frames, and where the first record begins that is neither a
   message of another channel than `bus` nor one of frames, all of eight bytes at most, from before `latest`). */
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
    if (PyErr_Occurred() || enough(&views[1], (end - at) / FEWEST, FRAME, "rows")
        || enough(&views[2], (end - at) / FEWEST, 8, "stamps")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    while (end - at >= MESSAGE_HEAD && chunk[at] == MESSAGE) {
        u64 size = load8(chunk + at + SIZE);
        if (size > (u64)(end - at - RECORD_HEAD) || size < MESSAGE_HEAD - RECORD_HEAD)
            break;
        if (load2(chunk + at + CHANNEL) == bus) {
            u64 stamp = load8(chunk + at + STAMP);
            if (stamp >= (u64)latest)
                break;
            i64 found = frames_of(chunk + at + MESSAGE_HEAD, (i64)size - (MESSAGE_HEAD - RECORD_HEAD), (i64)stamp,
                                  rows + FRAME * done, &stamps[done]);
            if (found < 0)
                break;
            done += found;
        }
        at += RECORD_HEAD + (i64)size;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    return Py_BuildValue("LL", (long long)done, (long long)at);
}
