/* Bytes from many places, side by side. */
#include "kernels.h"

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
