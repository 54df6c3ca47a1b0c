/* What the kernels share. They see bytes and numbers only: what these mean, the Python modules say that call them,
   each of which does the same without a kernel too. */
#ifndef TIMONEL_KERNELS_H
#define TIMONEL_KERNELS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the kernels are for little-endian machines"
#endif
#if UINTPTR_MAX != UINT64_MAX
#error "the kernels are for machines of 64 bits, on which places in NumPy's arrays have as many"
#endif

typedef uint8_t u8;
typedef uint16_t u16;
typedef uint32_t u32;
typedef uint64_t u64;
typedef int32_t i32;
typedef int64_t i64;

#define REPEATED(byte) ((u64)(byte) * 0x0101010101010101u)

static inline u16 load2(const u8 *at) { u16 word; memcpy(&word, at, 2); return word; }
static inline u32 load4(const u8 *at) { u32 word; memcpy(&word, at, 4); return word; }
static inline u64 load8(const u8 *at) { u64 word; memcpy(&word, at, 8); return word; }
static inline void store4(u8 *at, u32 word) { memcpy(at, &word, 4); }
static inline void store8(u8 *at, u64 word) { memcpy(at, &word, 8); }

/* A row of at most eight bytes: SocketCAN's, with zeros behind the data. */
static inline void put_row(u8 *row, u32 identifier, u32 length, u64 data)
{
    store8(row, (u64)length << 32 | identifier);
    store8(row + 8, length ? data & ~(u64)0 >> (64 - 8 * length) : 0);
}

/* Arguments: buffers of the callers' arrays, which must be contiguous. */
typedef struct {
    Py_buffer *views;
    int count;
} Buffers;

/* Views of `count` objects, of which those from `first_written` on are written to. 0, or -1 with an exception. */
int take_buffers(Buffers *buffers, Py_buffer *views, PyObject *const *objects, int count, int first_written);
void give_buffers_back(Buffers *buffers);

/* -1 with an exception if a buffer is shorter than `items` of `size` bytes. */
int enough(const Py_buffer *view, i64 items, i64 size, const char *name);

/* The number of 8 decimal digits, one a byte from 0 to 9, the first one lowest. */
static inline u32 eight_digits(u64 digits)
{
    digits = (digits * (10 << 8 | 1) >> 8) & 0x00FF00FF00FF00FFu;
    digits = (digits * (100 << 16 | 1) >> 16) & 0x0000FFFF0000FFFFu;
    return (u32)(digits * (10000ull << 32 | 1) >> 32);
}

/* Not zero if one of the bytes is none of 0 to 9, after `^ REPEATED('0')`. */
static inline u64 no_digits(u64 digits) { return (digits | (digits + REPEATED(6))) & REPEATED(0xF0); }

PyObject *candump_lines(PyObject *module, PyObject *arguments);
PyObject *captured_frames(PyObject *module, PyObject *arguments);
PyObject *recorded_frames(PyObject *module, PyObject *arguments);
PyObject *frame_codes(PyObject *module, PyObject *arguments);
PyObject *single_frames(PyObject *module, PyObject *arguments);
PyObject *fast_packets(PyObject *module, PyObject *arguments);
PyObject *cut_payloads(PyObject *module, PyObject *arguments);
PyObject *json_lines(PyObject *module, PyObject *arguments);
PyObject *gather(PyObject *module, PyObject *arguments);
PyObject *values_by_kind(PyObject *module, PyObject *arguments);
PyObject *item_places(PyObject *module, PyObject *arguments);
PyObject *sentence_lines(PyObject *module, PyObject *arguments);
PyObject *sentence_codes(PyObject *module, PyObject *arguments);
PyObject *sentence_groups(PyObject *module, PyObject *arguments);
PyObject *sentence_columns(PyObject *module, PyObject *arguments);

#endif
