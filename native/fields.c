/* Numbers of fixed size in many payloads; see timonel/nmea2000/fixed_columns.py. */
#include "kernels.h"

enum { WORD = 8, WORD_BITS = 64 };
#define NOT_A_NUMBER ((u64)0x7FF8 << 48) /* as NumPy's */

/* A field in each row of a table of bytes, the rows of which are `stride` apart. Of `rows` the first `safe` have a
   whole word to read from where the field begins, the last one ends where `end` is. */
typedef struct {
    const u8 *at, *end;
    i64 rows, safe, stride;
    int up, down;    /* shifts that leave nothing but the field of a word */
    bool is_signed;
} Cells;

/* The raw value of the field in a word. */
static inline i64 cut(const Cells *cells, u64 word)
{
    word <<= cells->up;
    return cells->is_signed ? (i64)word >> cells->down : (i64)(word >> cells->down);
}

/* The same in a row behind which there may be nothing to read. */
static inline i64 cut_last(const Cells *cells, i64 row)
{
    const u8 *at = cells->at + row * cells->stride;
    u64 word = 0;
    memcpy(&word, at, (size_t)(cells->end - at < WORD ? cells->end - at : WORD));
    return cut(cells, word);
}

/* The field of `bits` bits from bit `shift` of byte `first` on, in what `view` shows. -1 with an exception if it is not
   there or does not fit in a word. */
static int take_cells(Cells *cells, const Py_buffer *view, i64 first, int shift, int bits, bool is_signed)
{
    if (view->ndim != 2 || view->itemsize != 1 || view->strides[0] < 0 || (view->strides[1] != 1 && view->shape[1] > 1)) {
        PyErr_SetString(PyExc_ValueError, "block: rows of bytes that lie side by side are wanted");
        return -1;
    }
    i64 width = view->shape[1], bytes = (shift + bits + 7) / 8;
    if (first < 0 || first > width - bytes || shift < 0 || shift > 7 || bits < 1 || shift + bits > WORD_BITS
        || (bits == WORD_BITS && !is_signed)) {
        PyErr_SetString(PyExc_ValueError, "first, shift or bits: a field that is not in the rows, or too long");
        return -1;
    }
    i64 rows = view->shape[0], stride = view->strides[0];
    *cells = (Cells){(const u8 *)view->buf + first, NULL, rows, 0, stride, WORD_BITS - shift - bits, WORD_BITS - bits,
                     is_signed};
    if (rows) {
        i64 room = (rows - 1) * stride + width - first; /* from where the field of the first row begins */
        cells->end = cells->at + room;
        if (room >= WORD)
            cells->safe = stride && (room - WORD) / stride + 1 < rows ? (room - WORD) / stride + 1 : rows;
    }
    return 0;
}

/* The block, whose rows may be apart, and where the values go. */
static int take_views(Py_buffer *block, PyObject *rows, Py_buffer *out, PyObject *values)
{
    if (PyObject_GetBuffer(rows, block, PyBUF_STRIDES))
        return -1;
    if (PyObject_GetBuffer(values, out, PyBUF_WRITABLE)) {
        PyBuffer_Release(block);
        return -1;
    }
    return 0;
}

typedef struct {
    i64 lowest, highest, add; /* raw values; what is outside of the range is NaN */
    double factor, offset;
    bool divided;
} Scale;

/* Raw values that are worked on together: of type i32 or i64, the shorter of which a processor scales several of at a
   time. No branch depends on a value, as which of them are none cannot be guessed. */
enum { SOME = 512, SHORT_BITS = 30 };

#define SCALE_SOME(type)                                                                                              \
    static void scale_##type(const type *raw, i64 count, Scale scale, u64 *values)                                    \
    {                                                                                                                 \
        type add = (type)scale.add, lowest = (type)scale.lowest, highest = (type)scale.highest;                       \
        for (i64 row = 0; row < count; row++) {                                                                       \
            double value = (double)(type)((u64)raw[row] + (u64)add);                                                  \
            value = scale.divided ? value / scale.factor : value * scale.factor;                                      \
            value = scale.offset != 0 ? value + scale.offset : value;                                                 \
            u64 bits, none = -(u64)((raw[row] < lowest) | (raw[row] > highest));                                      \
            memcpy(&bits, &value, sizeof bits);                                                                       \
            values[row] = (bits & ~none) | (NOT_A_NUMBER & none);                                                     \
        }                                                                                                             \
    }                                                                                                                 \
    static void scale_cells_##type(const Cells *given, const Scale *scale, u64 *values)                               \
    {                                                                                                                 \
        const Cells cells = *given;                                                                                   \
        type raw[SOME];                                                                                               \
        for (i64 from = 0; from < cells.rows; from += SOME) {                                                         \
            i64 end = cells.rows - from < SOME ? cells.rows : from + SOME, safe = cells.safe < end ? cells.safe : end; \
            i64 row = from;                                                                                           \
            for (const u8 *at = cells.at + from * cells.stride; row < safe; row++, at += cells.stride)                \
                raw[row - from] = (type)cut(&cells, load8(at));                                                       \
            for (; row < end; row++)                                                                                  \
                raw[row - from] = (type)cut_last(&cells, row);                                                        \
            scale_##type(raw, end - from, *scale, values + from);                                                     \
        }                                                                                                             \
    }

SCALE_SOME(i32)
SCALE_SOME(i64)

static inline bool is_short(i64 value) { return value >= -(1 << SHORT_BITS) && value <= 1 << SHORT_BITS; }

/* (block, first, shift, bits, signed, lowest, highest, add, factor, divided, offset, values) -> None: the field of each
   row of `block`, uint8[n, width], as float64: `add`ed to, multiplied with `factor` or divided by it, then `offset`. */
PyObject *scaled_numbers(PyObject *module, PyObject *arguments)
{
    PyObject *rows, *objects;
    Py_buffer block, out;
    Cells cells;
    Scale scale;
    long long first, lowest, highest, add;
    int shift, bits, is_signed, divided;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OLiipLLLdpdO", &rows, &first, &shift, &bits, &is_signed, &lowest, &highest, &add,
                          &scale.factor, &divided, &scale.offset, &objects)
        || take_views(&block, rows, &out, objects))
        return NULL;
    scale.lowest = lowest;
    scale.highest = highest;
    scale.add = add;
    scale.divided = divided;
    if (!take_cells(&cells, &block, first, shift, bits, is_signed) && !enough(&out, cells.rows, 8, "values")) {
        Py_BEGIN_ALLOW_THREADS
        if (bits <= SHORT_BITS && is_short(lowest) && is_short(highest) && is_short(add))
            scale_cells_i32(&cells, &scale, out.buf);
        else
            scale_cells_i64(&cells, &scale, out.buf);
        Py_END_ALLOW_THREADS
    }
    PyBuffer_Release(&out);
    PyBuffer_Release(&block);
    if (PyErr_Occurred())
        return NULL;
    Py_RETURN_NONE;
}

#define PUT_CELLS(type)                                                                                               \
    static void put_##type(const Cells *given, type *values)                                                          \
    {                                                                                                                 \
        const Cells cells = *given;                                                                                   \
        const u8 *at = cells.at;                                                                                      \
        i64 row = 0;                                                                                                  \
        for (; row < cells.safe; row++, at += cells.stride)                                                           \
            values[row] = (type)cut(&cells, load8(at));                                                               \
        for (; row < cells.rows; row++)                                                                               \
            values[row] = (type)cut_last(&cells, row);                                                                \
    }

PUT_CELLS(u8)
PUT_CELLS(u16)
PUT_CELLS(u32)
PUT_CELLS(u64)

/* (block, first, shift, bits, signed, size, values) -> None: the field of each row of `block`, uint8[n, width], as
   integers of `size` bytes. */
PyObject *whole_numbers(PyObject *module, PyObject *arguments)
{
    PyObject *rows, *objects;
    Py_buffer block, out;
    Cells cells;
    long long first;
    int shift, bits, is_signed, size;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OLiipiO", &rows, &first, &shift, &bits, &is_signed, &size, &objects)
        || take_views(&block, rows, &out, objects))
        return NULL;
    if (size != 1 && size != 2 && size != 4 && size != 8)
        PyErr_SetString(PyExc_ValueError, "size: 1, 2, 4 or 8 is wanted");
    else if (!take_cells(&cells, &block, first, shift, bits, is_signed) && !enough(&out, cells.rows, size, "values")) {
        Py_BEGIN_ALLOW_THREADS
        switch (size) {
        case 1: put_u8(&cells, out.buf); break;
        case 2: put_u16(&cells, out.buf); break;
        case 4: put_u32(&cells, out.buf); break;
        default: put_u64(&cells, out.buf);
        }
        Py_END_ALLOW_THREADS
    }
    PyBuffer_Release(&out);
    PyBuffer_Release(&block);
    if (PyErr_Occurred())
        return NULL;
    Py_RETURN_NONE;
}
