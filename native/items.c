/* Where the items of repeating sets stand whose sizes the content tells; see timonel/nmea2000/catalogue_columns.py. */
#include "kernels.h"

/* What stands in an item, one behind the other; the numbers are those of catalogue_columns.py. */
enum { RUN, TEXT_LAU, TEXT_LZ, VALUE };

typedef struct {
    const u8 *flat;
    i64 size;
    const i64 *steps;  /* kind, and how many bytes a run has; for a value, how many stand before it that announce it */
    i64 count;
    const i64 *values; /* the size of a value, by the two bytes that announce it */
} Walk;

static inline i64 least(i64 one, i64 other) { return one < other ? one : other; }
static inline i64 most(i64 one, i64 other) { return one > other ? one : other; }

/* Where the item ends that begins at `at` in a payload that ends at `end`; -1 if that is outside of all bytes. */
static inline i64 behind(const Walk *walk, i64 at, i64 end)
{
    for (i64 each = 0; each < walk->count; each++) {
        i64 kind = walk->steps[2 * each], size = walk->steps[2 * each + 1];
        i64 first = kind == VALUE ? at - size : least(at, end);
        if (kind != RUN && (first < 0 || first > walk->size - (kind == VALUE ? 2 : 1)))
            return -1;
        switch (kind) {
        case RUN:
            at += size;
            break;
        case TEXT_LAU:
            at = end < at + 2 ? end : at + most(walk->flat[first], 2);
            break;
        case TEXT_LZ:
            at = end <= at ? at : at + walk->flat[first] + 2;
            break;
        default:
            at = most(least(at + walk->values[load2(walk->flat + first)], end), at);
        }
    }
    return at;
}

/* (flat, steps, values, at, end, count, least, found, places) -> how many: where the items of each payload stand, of
   which `count` are announced, and an item has `least` bytes; `at` becomes where they end. All are int64. */
PyObject *item_places(PyObject *module, PyObject *arguments)
{
    enum { FLAT, STEPS, VALUES, END, COUNT, AT, FOUND, PLACES, ALL };
    PyObject *objects[ALL];
    Py_buffer views[ALL];
    Buffers buffers;
    long long enough_bytes;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOLOO", &objects[FLAT], &objects[STEPS], &objects[VALUES], &objects[AT],
                          &objects[END], &objects[COUNT], &enough_bytes, &objects[FOUND], &objects[PLACES])
        || take_buffers(&buffers, views, objects, ALL, AT))
        return NULL;
    i64 rows = views[AT].len / 8, room = views[PLACES].len / 8, all = 0;
    if (enough(&views[VALUES], 1 << 16, 8, "values") || enough(&views[END], rows, 8, "end")
        || enough(&views[COUNT], rows, 8, "count") || enough(&views[FOUND], rows, 8, "found")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    Walk walk = {views[FLAT].buf, views[FLAT].len, views[STEPS].buf, views[STEPS].len / 16, views[VALUES].buf};
    const i64 *ends = views[END].buf, *counts = views[COUNT].buf;
    i64 *ats = views[AT].buf, *found = views[FOUND].buf, *places = views[PLACES].buf;
    bool in_range = true;
    Py_BEGIN_ALLOW_THREADS
    for (i64 row = 0; row < rows && in_range; row++) {
        i64 at = ats[row], end = ends[row], before = all;
        while (all - before < counts[row] && at + enough_bytes <= end) {
            if (all == room || (at = behind(&walk, places[all] = at, end)) < 0) {
                in_range = false;
                break;
            }
            all++;
        }
        ats[row] = at;
        found[row] = all - before;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (!in_range) {
        PyErr_SetString(PyExc_ValueError, "places: too few, or an item that is not in the payloads");
        return NULL;
    }
    return PyLong_FromLongLong(all);
}
