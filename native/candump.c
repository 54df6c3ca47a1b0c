/* `candump -L` text to frames; see timonel/recording/fast_candump.py.

       (1669809600.001488) can0 0DF11917#00FF7F1F02A3FFFF

   Every character is looked at: what is not exactly of this shape is left to the reader of single lines. */
#include "kernels.h"

enum {
    NAME = 20, /* where the interface's name begins */
    LONGEST_NAME = 15,
    LONGEST_LINE = 64, /* of this shape, its end and what is read beyond it included */
    ROW = 16,
};

/* The four bytes of eight hexadecimal digits, capitals, in their order; `fault` is not zero if one is none. */
static inline u32 four_bytes(u64 text, u64 *fault)
{
    u64 letters = text >> 6 & REPEATED(1), low = text & REPEATED(15);
    *fault |= (text & REPEATED(0xF0)) ^ (REPEATED(0x30) + (letters << 4));
    *fault |= (low + REPEATED(6) + 3 * letters) & REPEATED(0x10);      /* 0 to 9, or A to F */
    *fault |= letters & ~(low + REPEATED(15)) >> 4 & REPEATED(1);      /* not @ */
    u64 digits = low + 9 * letters;
    digits = (digits << 4 | digits >> 8) & 0x00FF00FF00FF00FFu;
    digits = (digits | digits >> 8) & 0x0000FFFF0000FFFFu;
    return (u32)(digits | digits >> 16);
}

/* Microseconds of `(1669809600.001488) `; -1 if it is nothing of the kind, or beyond 2096. */
static inline i64 microseconds(const u8 *line)
{
    u64 seconds = load8(line + 1) ^ REPEATED('0'), fraction = load8(line + 11) ^ 0x293030303030302Eu; /* .000000) */
    u64 tens = line[9] - '0', units = line[10] - '0';
    u64 fault = no_digits(seconds) | (fraction & 0xFF000000000000FFu) | no_digits(fraction) | ((seconds & 0xFF) > 3);
    if (fault || tens > 9 || units > 9 || line[0] != '(' || line[19] != ' ')
        return -1;
    i64 whole = (i64)eight_digits(seconds) * 100 + (i64)(tens * 10 + units);
    return whole * 1000000 + eight_digits(fraction) / 10; /* the point is a zero before, the bracket one behind */
}

/* The interface's name of the line before, with the blank behind it. */
typedef struct {
    u64 word, mask;
    int end;
} Name;

/* Where the interface's name ends; 0 if it does not. */
static inline int name_end(const u8 *line, Name *before)
{
    if (before->end && !((load8(line + NAME) ^ before->word) & before->mask))
        return before->end;
    int end = NAME;
    while (end <= NAME + LONGEST_NAME && line[end] > ' ' && line[end] <= '~')
        end++;
    if (end == NAME || end > NAME + LONGEST_NAME || line[end] != ' ')
        return 0;
    if (end - NAME < 8)
        *before = (Name){load8(line + NAME), ~(u64)0 >> 8 * (NAME + 7 - end), end};
    return end;
}

/* A bit of the first byte that is an end of line, and perhaps some behind it. */
static inline u64 line_feeds(u64 text)
{
    u64 other = text ^ REPEATED('\n');
    return (other - REPEATED(1)) & ~other & REPEATED(0x80);
}

/* Characters before the end of the line, 16 at most; -1 if it does not end there. */
static inline int data_digits(const u8 *data)
{
    u64 first = line_feeds(load8(data)), second = line_feeds(load8(data + 8));
    if (first)
        return __builtin_ctzll(first) >> 3;
    if (second)
        return 8 + (__builtin_ctzll(second) >> 3);
    return data[16] == '\n' ? 16 : -1;
}

static inline u64 first_digits(u64 text, int count)
{
    if (count >= 8)
        return text;
    u64 there = count > 0 ? ((u64)1 << 8 * count) - 1 : 0;
    return (text & there) | (REPEATED('0') & ~there);
}

/* How many bytes a line has that becomes a row and a stamp; 0 if it is not of the shape. */
static inline int one_line(const u8 *line, u8 *row, i64 *stamp, Name *name)
{
    i64 time = microseconds(line);
    int end = time < 0 ? 0 : name_end(line, name);
    if (!end)
        return 0;
    const u8 *identifier = line + end + 1;
    u64 fault = 0, digits;
    u32 flag;
    int hash;
    if (identifier[8] == '#') {
        hash = 8, digits = load8(identifier), flag = 0x80000000u;
    } else if (identifier[3] == '#') {
        hash = 3, digits = REPEATED('0') & ~((u64)0xFFFFFF << 40), flag = 0;
        digits |= (u64)identifier[0] << 40 | (u64)identifier[1] << 48 | (u64)identifier[2] << 56;
    } else {
        return 0;
    }
    const u8 *data = identifier + hash + 1;
    int count = data_digits(data);
    if (count < 0 || count & 1)
        return 0;
    u32 number = __builtin_bswap32(four_bytes(digits, &fault));
    u64 first = first_digits(load8(data), count), second = first_digits(load8(data + 8), count - 8);
    u64 bytes = four_bytes(first, &fault);
    bytes |= (u64)four_bytes(second, &fault) << 32;
    if (fault || number >> (flag ? 29 : 11))
        return 0;
    store8(row, (u64)count << 31 | flag | number);
    store8(row + 8, bytes);
    *stamp = time * 1000;
    return (int)(data - line) + count + 1;
}

/* (text, at, end, rows, stamps, filled) -> (filled, at): whole lines of text[at:end] become rows, as long as there is
   room and they are of the shape. */
PyObject *candump_lines(PyObject *module, PyObject *arguments)
{
    PyObject *objects[3];
    Py_buffer views[3];
    Buffers buffers;
    long long at, end, filled;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OLLOOL", &objects[0], &at, &end, &objects[1], &objects[2], &filled)
        || take_buffers(&buffers, views, objects, 3, 1))
        return NULL;
    i64 room = views[1].len / ROW;
    if (enough(&views[0], end, 1, "text") || enough(&views[2], room, 8, "stamps") || at < 0 || filled < 0) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "at and filled are not negative");
        give_buffers_back(&buffers);
        return NULL;
    }
    const u8 *text = views[0].buf;
    u8 *rows = views[1].buf;
    i64 *stamps = views[2].buf;
    Name name = {0, 0, 0};
    if (end > views[0].len - LONGEST_LINE)
        end = views[0].len - LONGEST_LINE;
    Py_BEGIN_ALLOW_THREADS
    while (at < end && filled < room) {
        int size = one_line(text + at, rows + ROW * filled, &stamps[filled], &name);
        if (!size)
            break;
        at += size;
        filled++;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    return Py_BuildValue("LL", (long long)filled, (long long)at);
}
