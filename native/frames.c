/* Frames to messages; see timonel/recording/assembly.py and fast_packets.py, which say what all of it means.

   A row has 16 bytes: identifier (4; bit 31: extended), length, flags, 2 unused, data (8). */
#include "kernels.h"
#include "sorting.h"

enum { ROW = 16, LENGTH = 4, DATA = 8, WHOLE_FLAG = 1, STANDARD = 1 << 18, PLACES = STANDARD + 0x800 };

static inline u32 place_of(u32 identifier)
{
    return identifier >> 31 ? identifier >> 8 & (STANDARD - 1) : STANDARD | (identifier & 0x7FF);
}

/* (rows, table, codes, counts) -> whether a row is a whole message: the code of each row, by the place of its PGN or
   standard identifier in `table`, and how many rows have each code; both uint16 and uint32. */
PyObject *frame_codes(PyObject *module, PyObject *arguments)
{
    PyObject *objects[4];
    Py_buffer views[4];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOO", &objects[0], &objects[1], &objects[2], &objects[3])
        || take_buffers(&buffers, views, objects, 4, 2))
        return NULL;
    i64 count = views[0].len / ROW, kinds = views[3].len / 4;
    if (enough(&views[1], PLACES, 2, "table") || enough(&views[2], count, 2, "codes")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    const u8 *rows = views[0].buf;
    const u16 *table = views[1].buf;
    u16 *codes = views[2].buf;
    u32 *counts = views[3].buf;
    u8 flags = 0;
    bool known = true;
    Py_BEGIN_ALLOW_THREADS
    for (i64 row = 0; row < count; row++) {
        u64 head = load8(rows + ROW * row);
        u16 code = table[place_of((u32)head)];
        flags |= head >> 40;
        codes[row] = code;
        if (code < kinds)
            counts[code]++;
        else
            known = false;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (!known) {
        PyErr_SetString(PyExc_ValueError, "counts: fewer than there are codes");
        return NULL;
    }
    return PyBool_FromLong(flags & WHOLE_FLAG);
}

/* (rows, stamps, codes, next, row, stamp, identifier, length, data) -> None: rows with code c go, in their order, from
   next[c] on; those where it is negative nowhere. Of int64: stamps, next, row, stamp; uint8: length. */
PyObject *single_frames(PyObject *module, PyObject *arguments)
{
    enum { ROWS, STAMPS, CODES, NEXT, ROW_OF, STAMP, IDENTIFIER, LENGTH_OF, DATA_OF, ALL };
    PyObject *objects[ALL];
    Py_buffer views[ALL];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOOOO", &objects[ROWS], &objects[STAMPS], &objects[CODES], &objects[NEXT],
                          &objects[ROW_OF], &objects[STAMP], &objects[IDENTIFIER], &objects[LENGTH_OF],
                          &objects[DATA_OF])
        || take_buffers(&buffers, views, objects, ALL, NEXT))
        return NULL;
    i64 count = views[ROWS].len / ROW, kinds = views[NEXT].len / 8, room = views[ROW_OF].len / 8;
    if (enough(&views[STAMPS], count, 8, "stamps") || enough(&views[CODES], count, 2, "codes")
        || enough(&views[STAMP], room, 8, "stamp") || enough(&views[IDENTIFIER], room, 4, "identifier")
        || enough(&views[LENGTH_OF], room, 1, "length") || enough(&views[DATA_OF], room, 8, "data")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    if (kinds >= CODES_MAX) {
        give_buffers_back(&buffers);
        PyErr_SetString(PyExc_ValueError, "next: more than there are codes");
        return NULL;
    }
    const u8 *rows = views[ROWS].buf;
    const i64 *stamps = views[STAMPS].buf;
    const u16 *codes = views[CODES].buf;
    i64 *next = views[NEXT].buf, *row_out = views[ROW_OF].buf, *stamp = views[STAMP].buf;
    u8 *length = views[LENGTH_OF].buf;
    u32 *identifier = views[IDENTIFIER].buf;
    u8 *data = views[DATA_OF].buf;
    Kinds chosen;
    i32 trouble = take_kinds(&chosen);
    Py_BEGIN_ALLOW_THREADS
    if (!trouble) {
        for (i64 code = 0; code < kinds; code++)
            if (next[code] >= 0)
                chosen.code[chosen.count++] = (u16)code;
        trouble = number_kinds(&chosen);
    }
    for (i64 begin = 0; begin < count && !trouble; begin += BLOCK) {
        u16 order[BLOCK];
        i64 some = count - begin < BLOCK ? count - begin : BLOCK;
        sort_block(codes + begin, some, &chosen, order);
        const u32 *ends = chosen.ends;
        u32 from = 0;
        for (u32 kind = 0; kind < chosen.count && !trouble; from = ends[kind++]) {
            i64 at = next[chosen.code[kind]], size = ends[kind] - from;
            if (at > room - size) {
                trouble = 2;
                break;
            }
            for (u32 place = from; place < ends[kind]; place++, at++) {
                i64 row = begin + order[place];
                u64 head = load8(rows + ROW * row);
                row_out[at] = row;
                stamp[at] = stamps[row];
                identifier[at] = (u32)head & 0x7FFFFFFF;
                length[at] = (u8)(head >> 32);
                store8(data + 8 * at, load8(rows + ROW * row + DATA));
            }
            next[chosen.code[kind]] = at;
        }
    }
    Py_END_ALLOW_THREADS
    give_kinds_back(&chosen);
    give_buffers_back(&buffers);
    if (trouble == 1)
        return PyErr_NoMemory();
    if (trouble) {
        PyErr_SetString(PyExc_ValueError, "row: too few");
        return NULL;
    }
    Py_RETURN_NONE;
}

enum { FIRST_FAST = 0x1ED00 << 8, STREAM = 0x3FFFFFF, STREAMS = (0x20000 << 8) - FIRST_FAST, SLOTS = 1 << 16,
       SLOT_SIZE = 64 };

/* Wraps around, as NumPy's does. */
static inline i64 minus(i64 later, i64 earlier) { return (i64)((u64)later - (u64)earlier); }

/* A slot, and its run that is on. */
typedef struct {
    i64 began, before;        /* times of the run's first and last frame */
    i64 last, offset;         /* row of its last frame, and where among the payloads its own begins */
    i32 run;                  /* its number from 1, 0 for none */
    i32 size, expected, carried, count; /* bytes announced, frames these take, bytes and frames that came */
    u8 index;
    bool whole, calm;         /* what the run is, as far as is known */
    bool first, waiting;      /* the slot's first run, and whether the slot is in use from before */
    bool dirty_before, calm_before;
} Slot;
_Static_assert(sizeof(Slot) <= SLOT_SIZE, "a slot is larger than the room for it");

/* What there is for the messages of one code: of the payloads from `bytes` to `end`, and so many frames may come. */
typedef struct {
    i64 bytes, end, frames;
} Share;

/* How many bytes a frame may take of its code's share: twice what it brings, as some belong to messages that miss
   others, whose room is taken too. */
enum { FRAME_SHARE = 14 };

/* Where the results go; frames are counted among those of fast packets, runs from 0. */
typedef struct {
    i64 *row;                 /* of each frame */
    i64 *begin, *last;        /* rows of a run's first and last frame */
    i32 *count;               /* of a run's frames */
    u16 *slot;                /* of a run */
    u8 *dirty;                /* a flag a run */
    Share *shares;            /* by code */
    i64 *place;               /* by code: where its next message goes */
    i32 *message;             /* the run of each message, whose frames are no more than those of its code */
    i64 *completed;           /* the row of its last frame */
    u32 *identifier;
    i64 *size, *offset;       /* of a message, and where it stands among the payloads */
    u8 *payloads;
    i32 *run;                 /* of each frame */
    i64 runs, frames, room;   /* how many there are, and how many frames and messages there may be */
} Found;

/* How old a message may be, how long after one of its frames the next may come, both in ns, and how long it may be. */
typedef struct {
    i64 age, gap, longest;
} Limits;

static inline void close_run(Slot *slot, Found *found)
{
    i32 run = slot->run - 1;
    bool whole = slot->whole && slot->count == slot->expected;
    bool dirty = !whole || (slot->first ? slot->waiting : slot->dirty_before && !slot->calm_before);
    found->dirty[run] = dirty;
    found->last[run] = slot->last;
    found->count[run] = slot->count;
    slot->dirty_before = dirty;
    slot->calm_before = slot->calm && whole;
}

/* A run that is whole becomes a message, unless more frames of it follow. */
static inline void put_message(u32 identifier, const Slot *slot, u16 code, Found *found)
{
    i64 place = found->place[code]++;
    found->message[place] = slot->run - 1;
    found->completed[place] = slot->last;
    found->identifier[place] = identifier & 0x7FFFFFFF;
    found->size[place] = slot->size;
    found->offset[place] = slot->offset;
}

/* Room for the payload of a run of so many frames, and for what is written behind it in whole words. False if there is
   none left: then it is not plain. */
static inline bool take_room(Slot *slot, Share *share)
{
    i64 bytes = 7 * (i64)slot->expected + 1;
    if (bytes > share->end - share->bytes)
        return false;
    slot->offset = share->bytes;
    share->bytes += bytes;
    return true;
}

static inline void put_frame(const u8 *rows, i64 row, i64 time, Slot *slot, u16 key, u16 code,
                             Found *found, const Limits *limits)
{
    const u8 *at = rows + ROW * row;
    u64 data = load8(at + DATA);
    u8 index = data & 31, length = at[LENGTH];
    i64 frame = found->frames++;
    found->row[frame] = row;
    if (!slot->run || !index) {
        bool first = !slot->run;
        if (!first)
            close_run(slot, found);
        slot->first = first;
        i64 run = found->runs++;
        slot->calm = !slot->first && minus(time, slot->before) > limits->gap;
        slot->run = (i32)run + 1;
        slot->began = time;
        slot->size = data >> 8 & 0xFF;
        slot->expected = 1 + slot->size / 7;
        slot->carried = length < 8 ? length - 2 : 6;
        slot->count = 1;
        slot->whole = !index && slot->size <= limits->longest && (length == 8 || slot->expected == 1)
            && take_room(slot, &found->shares[code]);
        if (slot->whole)
            store8(found->payloads + slot->offset, data >> 16);
        found->begin[run] = row;
        found->slot[run] = key;
    } else {
        i64 gap = minus(time, slot->before);
        if (gap < 0 || gap > limits->gap || index != (u8)(slot->index + 1) || slot->count >= slot->expected
            || (length < 8 && slot->count + 1 != slot->expected))
            slot->whole = false;
        if (slot->whole)
            store8(found->payloads + slot->offset + 7 * slot->count - 1, data >> 8);
        slot->count++;
        slot->carried += length < 8 ? length - 1 : 7;
    }
    slot->last = row;
    slot->index = index;
    slot->before = time;
    found->run[frame] = slot->run - 1;
    if (slot->whole && slot->count == slot->expected) {
        if (minus(time, slot->began) >= limits->age || slot->carried < slot->size)
            slot->whole = false;
        else
            put_message(load4(at), slot, code, found);
    }
}

/* A frame goes to its slot. How many streams are known then; -1 if there is no room for its own, or it has no data. */
static inline int receive_frame(const u8 *rows, i64 row, const i64 *now, u16 code, Slot *slots, u16 *streams,
                                int known, Found *found, const Limits *limits)
{
    const u8 *at = rows + ROW * row;
    u32 place = (load4(at) & STREAM) - FIRST_FAST;
    if (place >= STREAMS || !at[LENGTH] || found->frames == found->room || !found->shares[code].frames)
        return -1;
    if (!streams[place]) {
        if (known + 1 >= SLOTS >> 3)
            return -1;
        streams[place] = (u16)++known;
        memset(&slots[known << 3], 0, sizeof(Slot) << 3);
    }
    found->shares[code].frames--;
    u16 key = (u16)(streams[place] << 3 | at[DATA] >> 5);
    put_frame(rows, row, now[row], &slots[key], key, code, found, limits);
    return known;
}

/* The rows of runs that are not plain, at the beginning of `row`; how many they are. */
static inline i64 keep_dirty(Found *found)
{
    i64 kept = 0;
    for (i64 frame = 0; frame < found->frames; frame++) {
        found->row[kept] = found->row[frame];
        kept += found->dirty[found->run[frame]];
    }
    return kept;
}

/* Of each code from `first` on, where its messages go, which are no more than its frames. How many all are. */
static inline i64 share_out(const u32 *counts, i64 codes, i64 first, i64 *place, Share *shares)
{
    i64 all = 0;
    for (i64 code = 0; code < codes; code++) {
        i64 frames = code < first ? 0 : counts[code];
        place[code] = all;
        shares[code] = (Share){FRAME_SHARE * all, FRAME_SHARE * (all + frames), frames};
        all += frames;
    }
    return all;
}

/* (rows, now, codes, first, counts, limits, slots, streams, known, waiting, row, begin, last, count, slot, dirty,
   place, message, completed, identifier, size, offset, payloads) -> (known, runs, others): fast packets, which are the
   rows whose code is `first` or more, `counts` of each. `limits` are the longest age and gap, and message.

   Of `streams` those that are new are numbered on; known is -1 if there are too many of them, or a row has no data.
   `waiting` (uint16) are the slots in use; `slots` is room for 65,536 of 64 bytes, which is used again. The messages of
   code c end at place[c]; where they begin, so many frames of other codes are before them. `row` has those of the
   `others`: of frames that are in no plain run. */
PyObject *fast_packets(PyObject *module, PyObject *arguments)
{
    enum { ROWS, NOW, CODES, COUNTS, WAITING, SLOT_ROOM, STREAM_NUMBERS, ROW_OF, BEGIN, LAST, COUNT, SLOT, DIRTY, PLACE,
           MESSAGE, COMPLETED, IDENTIFIER, SIZE, OFFSET, PAYLOADS, ALL };
    PyObject *objects[ALL], *result = NULL;
    Py_buffer views[ALL];
    Buffers buffers;
    int first, known;
    long long max_age, max_gap, longest;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOiO(LLL)OOiOOOOOOOOOOOOOO", &objects[ROWS], &objects[NOW], &objects[CODES],
                          &first, &objects[COUNTS], &max_age, &max_gap, &longest, &objects[SLOT_ROOM],
                          &objects[STREAM_NUMBERS], &known, &objects[WAITING], &objects[ROW_OF], &objects[BEGIN],
                          &objects[LAST], &objects[COUNT], &objects[SLOT], &objects[DIRTY], &objects[PLACE],
                          &objects[MESSAGE], &objects[COMPLETED], &objects[IDENTIFIER], &objects[SIZE],
                          &objects[OFFSET], &objects[PAYLOADS])
        || take_buffers(&buffers, views, objects, ALL, SLOT_ROOM))
        return NULL;
    i64 all = views[ROWS].len / ROW, room = views[ROW_OF].len / 8, waiting = views[WAITING].len / 2,
        kinds = views[COUNTS].len / 4, others = 0;
    i32 *run = NULL;
    Share *shares = NULL;
    if (enough(&views[NOW], all, 8, "now") || enough(&views[CODES], all, 2, "codes")
        || enough(&views[SLOT_ROOM], SLOTS, SLOT_SIZE, "slots")
        || enough(&views[STREAM_NUMBERS], STREAMS, 2, "streams") || enough(&views[BEGIN], room, 8, "begin")
        || enough(&views[LAST], room, 8, "last") || enough(&views[COUNT], room, 4, "count")
        || enough(&views[SLOT], room, 2, "slot") || enough(&views[DIRTY], room, 1, "dirty")
        || enough(&views[PLACE], kinds, 8, "place") || enough(&views[MESSAGE], room, 4, "message")
        || enough(&views[COMPLETED], room, 8, "completed") || enough(&views[IDENTIFIER], room, 4, "identifier")
        || enough(&views[SIZE], room, 8, "size") || enough(&views[OFFSET], room, 8, "offset")
        || enough(&views[PAYLOADS], room, FRAME_SHARE, "payloads"))
        goto end;
    run = malloc(4 * (size_t)room + 4);
    shares = malloc(sizeof(Share) * (size_t)kinds + 1);
    if (!run || !shares) {
        PyErr_NoMemory();
        goto end;
    }
    i64 *place = views[PLACE].buf;
    if (room > INT32_MAX || known < 0 || known >= SLOTS >> 3
        || share_out(views[COUNTS].buf, kinds, first, place, shares) > room) {
        PyErr_SetString(PyExc_ValueError, "row, known or counts: too many");
        goto end;
    }
    const u8 *rows = views[ROWS].buf;
    const i64 *now = views[NOW].buf;
    const u16 *codes = views[CODES].buf, *waiting_slots = views[WAITING].buf;
    Slot *slots = views[SLOT_ROOM].buf;
    u16 *streams = views[STREAM_NUMBERS].buf;
    Found found = {views[ROW_OF].buf, views[BEGIN].buf, views[LAST].buf, views[COUNT].buf, views[SLOT].buf,
                   views[DIRTY].buf, shares, place, views[MESSAGE].buf, views[COMPLETED].buf, views[IDENTIFIER].buf,
                   views[SIZE].buf, views[OFFSET].buf, views[PAYLOADS].buf, run, 0, 0, room};
    Limits limits = {max_age, max_gap, longest};
    Py_BEGIN_ALLOW_THREADS
    memset(slots, 0, sizeof(Slot) * (size_t)(known + 1) << 3);
    for (i64 each = 0; each < waiting; each++)
        slots[waiting_slots[each]].waiting = true;
    for (i64 begin = 0; begin < all && known >= 0; begin += BLOCK) {
        u16 fast[BLOCK];
        i64 some = all - begin < BLOCK ? all - begin : BLOCK, wanted = 0;
        for (i64 row = 0; row < some; row++) {
            fast[wanted] = (u16)row;
            wanted += codes[begin + row] >= first;
        }
        for (i64 each = 0; each < wanted && known >= 0; each++) {
            i64 row = begin + fast[each];
            known = codes[row] < kinds
                ? receive_frame(rows, row, now, codes[row], slots, streams, known, &found, &limits) : -1;
        }
    }
    for (int key = 8; key < (known + 1) << 3; key++)
        if (slots[key].run)
            close_run(&slots[key], &found);
    if (known >= 0)
        others = keep_dirty(&found);
    Py_END_ALLOW_THREADS
    result = Py_BuildValue("iLL", known, (long long)found.runs, (long long)others);
end:
    free(run);
    free(shares);
    give_buffers_back(&buffers);
    return result;
}

enum { WORD = 8 };

/* Copies `size` bytes in words, and so up to seven more, to where up to `room` may be written; false if that or what is
   `left` of the bytes is too little for it. */
static inline bool copy_words(u8 *to, i64 room, const u8 *from, i64 left, i64 size)
{
    i64 whole = (size + WORD - 1) / WORD * WORD;
    if (whole > room || whole > left)
        return false;
    for (i64 place = 0; place < whole; place += WORD)
        store8(to + place, load8(from + place));
    return true;
}

/* (payloads, offset, size, cells, width) -> None: `size` bytes from each offset, and zeros, to rows of `width`. */
PyObject *cut_payloads(PyObject *module, PyObject *arguments)
{
    PyObject *objects[4];
    Py_buffer views[4];
    Buffers buffers;
    long long width;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOL", &objects[0], &objects[1], &objects[2], &objects[3], &width)
        || take_buffers(&buffers, views, objects, 4, 3))
        return NULL;
    i64 count = views[1].len / 8;
    if (width < 1 || enough(&views[2], count, 8, "size") || enough(&views[3], count, width, "cells")) {
        give_buffers_back(&buffers);
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "width: 1 at least");
        return NULL;
    }
    const u8 *payloads = views[0].buf;
    const i64 *offset = views[1].buf, *size = views[2].buf;
    u8 *cells = views[3].buf;
    i64 room = count * width;
    bool in_range = true;
    Py_BEGIN_ALLOW_THREADS
    for (i64 each = 0; each < count; each++, cells += width, room -= width) {
        if (size[each] < 0 || size[each] > width || offset[each] < 0 || offset[each] > views[0].len - size[each]) {
            in_range = false;
            break;
        }
        const u8 *from = payloads + offset[each];
        /* What it writes of the next row, that row overwrites. */
        if (!copy_words(cells, room, from, views[0].len - offset[each], size[each]))
            memcpy(cells, from, (size_t)size[each]);
        memset(cells + size[each], 0, (size_t)(width - size[each]));
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (!in_range) {
        PyErr_SetString(PyExc_ValueError, "payloads: a piece that is not in them");
        return NULL;
    }
    Py_RETURN_NONE;
}
