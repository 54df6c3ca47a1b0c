#include "kernels.h"

int take_buffers(Buffers *buffers, Py_buffer *views, PyObject *const *objects, int count, int first_written)
{
    buffers->views = views;
    buffers->count = 0;
    for (int place = 0; place < count; place++) {
        if (PyObject_GetBuffer(objects[place], &views[place], place < first_written ? PyBUF_SIMPLE : PyBUF_WRITABLE)) {
            give_buffers_back(buffers);
            return -1;
        }
        buffers->count++;
    }
    return 0;
}

void give_buffers_back(Buffers *buffers)
{
    while (buffers->count)
        PyBuffer_Release(&buffers->views[--buffers->count]);
}

int enough(const Py_buffer *view, i64 items, i64 size, const char *name)
{
    if (items >= 0 && items <= view->len / size)
        return 0;
    PyErr_Format(PyExc_ValueError, "%s: %zd bytes are too few for %lld of %lld", name, view->len, (long long)items,
                 (long long)size);
    return -1;
}

static PyMethodDef methods[] = {
    {"candump_lines", candump_lines, METH_VARARGS, NULL},
    {"captured_frames", captured_frames, METH_VARARGS, NULL},
    {"recorded_frames", recorded_frames, METH_VARARGS, NULL},
    {"frame_codes", frame_codes, METH_VARARGS, NULL},
    {"single_frames", single_frames, METH_VARARGS, NULL},
    {"fast_packets", fast_packets, METH_VARARGS, NULL},
    {"cut_payloads", cut_payloads, METH_VARARGS, NULL},
    {"json_lines", json_lines, METH_VARARGS, NULL},
    {"gather", gather, METH_VARARGS, NULL},
    {"values_by_kind", values_by_kind, METH_VARARGS, NULL},
    {"item_places", item_places, METH_VARARGS, NULL},
    {"sentence_lines", sentence_lines, METH_VARARGS, NULL},
    {"sentence_codes", sentence_codes, METH_VARARGS, NULL},
    {"sentence_groups", sentence_groups, METH_VARARGS, NULL},
    {"sentence_columns", sentence_columns, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "timonel._native", NULL, 0, methods, NULL, NULL, NULL,
                                        NULL};

PyMODINIT_FUNC PyInit__native(void) { return PyModuleDef_Init(&definition); }
