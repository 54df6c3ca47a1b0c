/* Bytes from many places, side by side. */
#include "kernels.h"
#include "sorting.h"

/* (flat, places, cells, size) -> None: `size` bytes from each place (int64). */
PyObject *gather(PyObject *module, PyObject *arguments)
{
    PyObject *objects[3];
    Py_buffer views[3];
    Buffers buffers;
    long long size;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOL", &objects[0], &objects[1], &objects[2], &size)
        || take_buffers(&buffers, views, objects, 3, 2))
        return NULL;
    i64 count = views[1].len / 8, room = views[0].len - size;
    if (size < 1 || enough(&views[2], count, size, "cells")) {
        give_buffers_back(&buffers);
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "size: 1 at least");
        return NULL;
    }
    const u8 *flat = views[0].buf;
    const i64 *places = views[1].buf;
    u8 *cells = views[2].buf;
    bool in_range = true;
    Py_BEGIN_ALLOW_THREADS
    for (i64 each = 0; each < count; each++) {
        if (places[each] < 0 || places[each] > room) {
            in_range = false;
            break;
        }
        const u8 *from = flat + places[each];
        switch (size) { /* of a size that is known, a copy is a word or two */
        case 1: cells[each] = *from; break;
        case 2: memcpy(cells + 2 * each, from, 2); break;
        case 3: memcpy(cells + 3 * each, from, 3); break;
        case 4: memcpy(cells + 4 * each, from, 4); break;
        case 8: memcpy(cells + 8 * each, from, 8); break;
        case 12: memcpy(cells + 12 * each, from, 12); break;
        default: memcpy(cells + size * each, from, (size_t)size);
        }
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (!in_range) {
        PyErr_SetString(PyExc_ValueError, "places: one that is not in the bytes");
        return NULL;
    }
    Py_RETURN_NONE;
}

enum { WORD = 8 };

/* The places, what is left behind them, and where it all goes. */
typedef struct {
    const u8 *flat;
    i64 room;
    const u16 *kinds;
    const i64 *places, *left;
    i64 count, *order;
    u8 *words;
} Sorting;

/* Of a kind, those of the block from `begin` on whose numbers these are. False if a place is none. */
static inline bool move_some(const Sorting *sorting, i64 begin, const u16 *numbers, i64 count, i64 to, i64 *least)
{
    i64 fewest = *least;
    for (i64 each = 0; each < count; each++, to++) {
        i64 from = begin + numbers[each], place = sorting->places[from], left = sorting->left[from];
        if (place < 0 || place > sorting->room)
            return false;
        fewest = left < fewest ? left : fewest;
        sorting->order[to] = from;
        store8(sorting->words + WORD * to, load8(sorting->flat + place));
    }
    *least = fewest;
    return true;
}

/* 0, or 1 without memory, or 2 if a place is none. How many kinds there are is written; of each where they end, and the
   least that is left. */
static int sort_kinds(Sorting *sorting, i64 *ends, i64 *least, i64 *found)
{
    Kinds chosen;
    u32 *counts = calloc(CODES_MAX, 4);
    int trouble = take_kinds(&chosen) || !counts;
    for (i64 each = 0; each < sorting->count && !trouble; each++)
        counts[sorting->kinds[each]]++;
    for (u32 code = 0; code < CODES_MAX && !trouble; code++)
        if (counts[code])
            chosen.code[chosen.count++] = (u16)code;
    trouble = trouble || chosen.count == CODES_MAX || number_kinds(&chosen);
    for (u32 kind = 0; kind < chosen.count && !trouble; kind++) {
        ends[kind] = kind ? ends[kind - 1] + counts[chosen.code[kind - 1]] : 0; /* where they begin, at first */
        least[kind] = INT64_MAX;
    }
    for (i64 begin = 0; begin < sorting->count && !trouble; begin += BLOCK) {
        u16 order[BLOCK];
        i64 some = sorting->count - begin < BLOCK ? sorting->count - begin : BLOCK;
        sort_block(sorting->kinds + begin, some, &chosen, order);
        for (u32 kind = 0, from = 0; kind < chosen.count && !trouble; from = chosen.ends[kind++]) {
            i64 size = chosen.ends[kind] - from;
            if (!move_some(sorting, begin, order + from, size, ends[kind], &least[kind]))
                trouble = 2;
            ends[kind] += size;
        }
    }
    *found = chosen.count;
    free(counts);
    give_kinds_back(&chosen);
    return trouble;
}

/* (flat, kinds, places, left, order, words, ends, least) -> how many kinds there are: the numbers of some places, by
   kind (uint16), and the eight bytes that stand there; where those of each kind end, and the least that is left behind
   them. All others are int64. */
PyObject *values_by_kind(PyObject *module, PyObject *arguments)
{
    enum { FLAT, KINDS, PLACES, LEFT, ORDER, WORDS, ENDS, LEAST, ALL };
    PyObject *objects[ALL];
    Py_buffer views[ALL];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOOO", &objects[FLAT], &objects[KINDS], &objects[PLACES], &objects[LEFT],
                          &objects[ORDER], &objects[WORDS], &objects[ENDS], &objects[LEAST])
        || take_buffers(&buffers, views, objects, ALL, ORDER))
        return NULL;
    i64 count = views[KINDS].len / 2, most = count < CODES_MAX ? count : CODES_MAX, found = 0;
    if (enough(&views[PLACES], count, 8, "places") || enough(&views[LEFT], count, 8, "left")
        || enough(&views[ORDER], count, 8, "order") || enough(&views[WORDS], count, WORD, "words")
        || enough(&views[ENDS], most, 8, "ends") || enough(&views[LEAST], most, 8, "least")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    Sorting sorting = {views[FLAT].buf, views[FLAT].len - WORD, views[KINDS].buf, views[PLACES].buf, views[LEFT].buf,
                       count, views[ORDER].buf, views[WORDS].buf};
    int trouble;
    Py_BEGIN_ALLOW_THREADS
    trouble = sort_kinds(&sorting, views[ENDS].buf, views[LEAST].buf, &found);
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (trouble == 1)
        return PyErr_NoMemory();
    if (trouble) {
        PyErr_SetString(PyExc_ValueError, "places: one that is not in the bytes");
        return NULL;
    }
    return PyLong_FromLongLong(found);
}
