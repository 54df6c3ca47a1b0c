/* Messages to lines of JSON; see timonel/recording/sinks/line_steps.py, which says what the steps are made of.

       {"time": 1669809600.001488, "priority": 2, "source": 204, "destination": 255, "pgn": 127250, "name": ...}

   A line is written from left to right, as its payload is read. What a step cannot write stops the page: the caller
   writes the line, or finds the text of a code that was not met before, and goes on from there. */
#include "kernels.h"

enum { TEXT, NUMBER, CODE, HEXADECIMAL, ASCII, BITS, GO, COUNT, ITEMS, LAU, LZ, VALUE, UNTOLD, KINDS };
enum { DONE, ROOM, NEW_CODE, BY_HAND }; /* why it stops */
enum { SLACK = 64, LONGEST = 512 };     /* bytes behind a text, of any kind; and what a step needs but for its texts */

/* Places are in bits from where the line is in its payload. `text` and `size` is what stands before the value. */
typedef struct {
    i64 kind, text, size;
    i64 offset, bits, need;                           /* `need` bits must be there */
    i64 sign, lowest, highest;                        /* raw values */
    i64 add, factor, places, inverse, most;           /* (raw + add) * factor / 10 ** places, exact up to `most` */
    i64 slots;                                        /* of codes: 0, or where its text is and its size */
    i64 steps, least, counter;                        /* of items: how many steps, bytes, which count */
} Step;

typedef struct {
    i64 step, steps, head, head_size, known, rows, width, next;
} Table;

enum { STAMP, IDENTIFIER, PAYLOADS, LENGTHS, COLUMNS };

typedef struct {
    const u8 *texts;
    i64 texts_size;
    const u64 *slots;
    const Step *all;
    i64 steps;
} Known;

/* A line that is being written. */
typedef struct {
    const Known *known;
    const u8 *payload, *readable; /* and where nothing is read any more */
    i64 length, at;
    i64 counts[2];
    u8 *out, *end;
    int stop;
    i64 step, code; /* what stopped it */
} Line;

static const u64 TENS[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000, 1000000000, 10000000000,
                           100000000000, 1000000000000, 10000000000000, 100000000000000, 1000000000000000,
                           10000000000000000, 100000000000000000, 1000000000000000000};

static inline bool room(Line *line, i64 size)
{
    if (line->end - line->out >= size + LONGEST)
        return true;
    line->stop = ROOM;
    return false;
}

/* Up to 31 bytes too many are written, and read. */
static inline void put(u8 **out, const u8 *text, i64 size)
{
    for (i64 done = 0; done < size; done += 32)
        memcpy(*out + done, text + done, 32);
    *out += size;
}

#define PUT(out, text) do { memcpy(*(out), text, sizeof(text) - 1); *(out) += sizeof(text) - 1; } while (0)

static inline void put_name(Line *line, const Step *step)
{
    put(&line->out, line->known->texts + step->text, step->size);
}

/* Eight digits of a number, as they are read. */
static inline u64 digits_of(u32 number)
{
    u64 fours = number / 10000 | (u64)(number % 10000) << 32;
    u64 hundreds = (fours * 10486 >> 20) & 0x0000007F0000007Fu;
    u64 twos = hundreds | (fours - 100 * hundreds) << 16;
    u64 tens = (twos * 103 >> 10) & 0x000F000F000F000Fu;
    return (tens | (twos - 10 * tens) << 8) + REPEATED('0');
}

#ifndef __SIZEOF_INT128__
#error "the kernels are for machines with integers of 128 bits"
#endif
typedef unsigned __int128 u128;

static inline void store16(u8 *at, u128 word) { memcpy(at, &word, 16); }

static inline u128 sixteen_digits(u64 number)
{
    return (u128)digits_of((u32)(number % 100000000)) << 64 | digits_of((u32)(number / 100000000));
}

/* How many of eight digits are zeros before the others, or behind them. */
static inline int zeros_before(u64 digits) { return __builtin_ctzll((digits ^ REPEATED('0')) | (u64)1 << 63) >> 3; }
static inline int zeros_behind(u64 digits) { return __builtin_clzll((digits ^ REPEATED('0')) | 1) >> 3; }

static inline void put_whole(u8 **out, u64 number)
{
    if (number < 100000000) {
        u64 digits = digits_of((u32)number);
        int zeros = zeros_before(digits);
        store8(*out, digits >> 8 * zeros);
        *out += 8 - zeros;
        return;
    }
    put_whole(out, number / 100000000); /* never zero */
    store8(*out, digits_of((u32)(number % 100000000)));
    *out += 8;
}

/* number / 10 ** places below 0.0001. */
static void put_small(u8 **out, u64 number, int places)
{
    u8 digits[20], *end = digits + sizeof digits, *first = end;
    while (!(number % 10))
        number /= 10, places--;
    for (; number; number /= 10)
        *--first = '0' + (u8)(number % 10);
    int exponent = places + 1 - (int)(end - first);
    *(*out)++ = *first++;
    if (first < end)
        *(*out)++ = '.';
    while (first < end)
        *(*out)++ = *first++;
    PUT(out, "e-");
    *(*out)++ = '0' + (u8)(exponent / 10);
    *(*out)++ = '0' + (u8)(exponent % 10);
}

/* number / 10 ** places, less than 10 ** 16 and with 1 to 16 places, as Python prints it: that of all decimals that are
   read as the same float which has the fewest digits. */
static inline void put_decimal(u8 **out, u64 number, int places)
{
    if (places > 4 && number && number < TENS[places - 4]) {
        put_small(out, number, places);
    } else if (number < 100000000 && places < 8) {
        u64 digits = digits_of((u32)number);
        int first = zeros_before(digits), point = 8 - places, behind = places - zeros_behind(digits);
        if (first > point - 1)
            first = point - 1;
        store8(*out, digits >> 8 * first);
        *out += point - first;
        *(*out)++ = '.';
        store8(*out, digits >> 8 * point);
        *out += behind > 1 ? behind : 1;
    } else {
        u128 digits = sixteen_digits(number);
        u64 high = (u64)digits, low = (u64)(digits >> 64);
        int first = zeros_before(high), point = 16 - places, behind = places - zeros_behind(low);
        if (first == 7 && (high >> 56) == '0')
            first = 8 + zeros_before(low);
        if (low == REPEATED('0'))
            behind = places - 8 - zeros_behind(high);
        if (first >= point) {
            *(*out)++ = '0';
        } else {
            store16(*out, digits >> 8 * first);
            *out += point - first;
        }
        *(*out)++ = '.';
        store16(*out, digits >> 8 * point);
        *out += behind > 1 ? behind : 1;
    }
}

/* The same for a float from 0.1 to less than 1e15: 15 digits are enough, or the 16 or 17 that are nearest. */
static void put_float(u8 **out, double value)
{
    int places = 15;
    for (u64 whole = (u64)value; whole; whole /= 10)
        places--;
    u64 fifteen = (u64)(value * (double)TENS[places] + 0.5);
    if ((double)fifteen / (double)TENS[places] == value) {
        put_decimal(out, places ? fifteen : 10 * fifteen, places ? places : 1);
        return;
    }
    u64 word;
    memcpy(&word, &value, 8);
    u64 fraction = (word & (((u64)1 << 52) - 1)) | (u64)1 << 52;
    int shift = 1075 - (int)(word >> 52);
    u128 half = (u128)1 << (shift - 1), exact = (u128)fraction * TENS[places + 1], found = (exact + half) >> shift;
    u128 there = found << shift, off = there > exact ? there - exact : exact - there, unit = TENS[places + 1];
    bool below = there < exact && fraction == (u64)1 << 52; /* where floats lie twice as close */
    u128 doubled = off << (below ? 2 : 1);
    if (doubled < unit || (doubled == unit && !(fraction & 1))) {
        places += 1;
    } else {
        places += 2;
        found = ((u128)fraction * TENS[places] + half) >> shift;
    }
    u64 number = (u64)found;
    put_whole(out, number / TENS[places]);
    *(*out)++ = '.';
    u64 rest = number % TENS[places];
    for (int place = places; place--; rest /= 10)
        (*out)[place] = '0' + (u8)(rest % 10);
    *out += places;
}
static const char HEX_DIGITS[] = "0123456789ABCDEF";

static inline void put_hexadecimal(u8 **out, const u8 *data, i64 count)
{
    for (i64 byte = 0; byte < count; byte++) {
        *(*out)++ = (u8)HEX_DIGITS[data[byte] >> 4];
        *(*out)++ = (u8)HEX_DIGITS[data[byte] & 15];
    }
}

/* Whether so many bits are there from where the line is. */
static inline bool there(const Line *line, i64 need)
{
    i64 have = line->length - line->at;
    return need <= 0 || 8 * have >= need;
}

/* Bits of a field that is there. */
static inline u64 raw_value(const Line *line, const Step *step)
{
    i64 place = 8 * line->at + step->offset;
    const u8 *from = line->payload + (place >> 3);
    u64 word = 0;
    if (line->readable - from >= 8)
        word = load8(from);
    else
        memcpy(&word, from, (size_t)(line->readable - from));
    word >>= place & 7;
    return step->bits < 64 ? word & (((u64)1 << step->bits) - 1) : word;
}

/* Whether there is a value, and which. */
static inline bool number_of(const Line *line, const Step *step, i64 *raw)
{
    if (!there(line, step->need))
        return false;
    u64 word = raw_value(line, step);
    *raw = (i64)word;
    if (!step->sign)
        return word >= (u64)step->lowest && word <= (u64)step->highest;
    *raw = (i64)(word << (64 - step->bits)) >> (64 - step->bits);
    return *raw >= step->lowest && *raw <= step->highest;
}

static inline void put_number(Line *line, const Step *step)
{
    i64 raw;
    if (!number_of(line, step, &raw))
        return;
    put_name(line, step);
    i64 value = (i64)((step->places ? (u64)raw : (u64)raw * (u64)step->factor) + (u64)step->add);
    bool negative = value < 0 && (step->sign || step->add);
    u64 magnitude = negative ? -(u64)value : (u64)value;
    if (negative)
        *line->out++ = '-';
    if (!step->places)
        put_whole(&line->out, magnitude);
    else if (magnitude <= (u64)step->most)
        put_decimal(&line->out, magnitude * (u64)step->factor, (int)step->places);
    else
        put_float(&line->out, (double)magnitude / (double)step->inverse);
}

static inline void unknown(Line *line, const Step *step, u64 code)
{
    line->stop = NEW_CODE;
    line->step = step - line->known->all;
    line->code = (i64)code;
}

/* A text that was found for the code, with the name in it. */
static inline void put_code(Line *line, const Step *step)
{
    if (!there(line, step->need))
        return;
    if (!there(line, step->most)) { /* what else tells it */
        line->stop = BY_HAND;
        return;
    }
    u64 code = raw_value(line, step), slot = line->known->slots[(u64)step->slots + code];
    i64 size = (i64)(slot & 0xFFFF), text = (i64)(slot >> 16);
    if (!slot)
        unknown(line, step, code);
    else if (text + size + SLACK > line->known->texts_size)
        line->stop = BY_HAND;
    else if (room(line, size))
        put(&line->out, line->known->texts + text, size);
}

static inline i64 least_of(i64 one, i64 other) { return one < other ? one : other; }

static inline void put_bytes(Line *line, const Step *step, i64 first, i64 count)
{
    if (count <= 0 || !room(line, 2 * count))
        return;
    put_name(line, step);
    *line->out++ = '"';
    put_hexadecimal(&line->out, line->payload + first, count);
    *line->out++ = '"';
}

/* Bits between bytes, as the bytes of their number. */
static inline void put_bits(Line *line, const Step *step)
{
    if (!there(line, step->need))
        return;
    u64 word = raw_value(line, step);
    put_name(line, step);
    *line->out++ = '"';
    put_hexadecimal(&line->out, (const u8 *)&word, (step->bits + 7) / 8);
    *line->out++ = '"';
}

/* Text of ASCII only; what is not of it, or has to be escaped as a number, is written by hand. */
static inline void put_text(Line *line, const Step *step, const u8 *text, i64 size)
{
    if (!size || !room(line, 2 * size))
        return;
    put_name(line, step);
    *line->out++ = '"';
    for (i64 each = 0; each < size; each++) {
        if (text[each] < ' ')
            line->stop = BY_HAND;
        if (text[each] == '"' || text[each] == '\\')
            *line->out++ = '\\';
        *line->out++ = text[each];
    }
    *line->out++ = '"';
}

static inline i64 until(const u8 *text, i64 size, u8 end)
{
    i64 each = 0;
    while (each < size && text[each] != end)
        each++;
    return each;
}

static inline bool is_ascii(const u8 *text, i64 size)
{
    u8 all = 0;
    for (i64 each = 0; each < size; each++)
        all |= text[each];
    return all < 0x80;
}

/* Without blanks behind it. */
static inline void put_words(Line *line, const Step *step, const u8 *text, i64 size)
{
    if (!is_ascii(text, size)) {
        line->stop = BY_HAND;
        return;
    }
    while (size && (text[size - 1] == ' ' || (text[size - 1] >= 9 && text[size - 1] <= 13)
                    || (text[size - 1] >= 28 && text[size - 1] <= 31)))
        size--;
    put_text(line, step, text, size);
}

/* Up to its padding. */
static inline void put_fixed_text(Line *line, const Step *step)
{
    i64 first = line->at + step->offset / 8, size = least_of(step->bits / 8, line->length - first);
    if (size <= 0)
        return;
    const u8 *text = line->payload + first;
    put_words(line, step, text, until(text, until(text, until(text, size, 0xFF), 0), '@'));
}

/* Text with a length, which counts itself, and what kind it is of. */
static inline void put_lau(Line *line, const Step *step)
{
    if (line->length < line->at + 2) {
        line->at = line->length;
        return;
    }
    const u8 *text = line->payload + line->at;
    i64 whole = text[0] > 2 ? text[0] : 2, size = least_of(whole, line->length - line->at) - 2;
    line->at += whole;
    if (text[1] > 1)
        return;
    if (!text[1]) { /* two bytes a character */
        if (size > 1)
            line->stop = BY_HAND;
        return;
    }
    text += 2;
    size = until(text, size, 0xFF);
    if (!is_ascii(text, size)) {
        line->stop = BY_HAND;
        return;
    }
    size = until(text, size, 0);
    while (size && strchr("@ \t\r\n", text[size - 1]))
        size--;
    put_text(line, step, text, size);
}

/* Text with a length, and a zero behind it. */
static inline void put_lz(Line *line, const Step *step)
{
    if (line->length <= line->at)
        return;
    const u8 *text = line->payload + line->at + 1;
    i64 whole = line->payload[line->at], size = least_of(whole, line->length - line->at - 1);
    line->at += whole + 2;
    put_words(line, step, text, until(text, size, 0));
}

/* A value behind its key: which step writes it is found by what stands before it. */
static inline void put_value(Line *line, const Step *step)
{
    i64 place = 8 * line->at + step->offset;
    if (place < 0 || place + step->bits > 8 * line->length) {
        line->stop = BY_HAND;
        return;
    }
    u64 code = raw_value(line, step), slot = line->known->slots[(u64)step->slots + code];
    if (!slot || slot > (u64)line->known->steps) {
        unknown(line, step, code);
        return;
    }
    const Step *told = &line->known->all[slot - 1];
    i64 left = line->length - line->at, count = least_of(told->least, left);
    if (!room(line, told->size))
        return;
    if (told->least > left || told->kind == HEXADECIMAL)
        put_bytes(line, told, line->at, count);
    else if (told->kind == NUMBER)
        put_number(line, told);
    else if (told->kind == CODE)
        put_code(line, told);
    else
        line->stop = BY_HAND;
    line->at += count;
}

/* One step of a line or of an item. */
static inline void put_step(Line *line, const Step *step)
{
    i64 raw;
    if (!room(line, step->size))
        return;
    switch (step->kind) {
    case TEXT:
        put_name(line, step);
        break;
    case NUMBER:
        put_number(line, step);
        break;
    case CODE:
        put_code(line, step);
        break;
    case HEXADECIMAL:
        put_bytes(line, step, line->at + step->offset / 8,
                  least_of(step->bits / 8, line->length - line->at - step->offset / 8));
        break;
    case BITS:
        put_bits(line, step);
        break;
    case ASCII:
        put_fixed_text(line, step);
        break;
    case GO:
        line->at += step->least;
        break;
    case COUNT:
        line->counts[step->counter] = number_of(line, step, &raw) ? raw : 0;
        break;
    case LAU:
        put_lau(line, step);
        break;
    case LZ:
        put_lz(line, step);
        break;
    case VALUE:
        put_value(line, step);
        break;
    default:
        line->stop = BY_HAND;
    }
}

static inline void put_items(Line *line, const Step *step)
{
    i64 count = step->counter < 0 ? step->most : line->counts[step->counter], items = 0;
    for (; items < count && line->at + step->least <= line->length && !line->stop; items++) {
        if (!room(line, step->size))
            return;
        if (items)
            PUT(&line->out, ", {");
        else
            put_name(line, step);
        u8 *begin = line->out, kept[2] = {begin[-2], begin[-1]};
        line->out -= 2; /* the first field has no comma before it */
        for (i64 each = 1; each <= step->steps && !line->stop; each++)
            put_step(line, step + each);
        memcpy(begin - 2, kept, 2);
        if (line->out < begin)
            line->out = begin;
        *line->out++ = '}';
    }
    if (items)
        *line->out++ = ']';
}

static inline void put_fields(Line *line, const Table *table)
{
    static const u8 fields[] = "\", \"fields\": {";
    u8 *begin = line->out;
    line->out += sizeof(fields) - 3;
    const Step *steps = line->known->all + table->step;
    for (i64 each = 0; each < table->steps && !line->stop; each++) {
        if (steps[each].kind == ITEMS) {
            put_items(line, &steps[each]);
            each += steps[each].steps;
        } else {
            put_step(line, &steps[each]);
        }
    }
    memcpy(begin, fields, sizeof(fields) - 1);
    if (line->out < begin + sizeof(fields) - 1)
        line->out = begin + sizeof(fields) - 1;
    PUT(&line->out, "}}\n");
}

/* Nanoseconds, to the microsecond; the smallest number is none. */
static inline void put_time(u8 **out, i64 stamp)
{
    PUT(out, "{\"time\": ");
    if (stamp == INT64_MIN) {
        PUT(out, "null");
        return;
    }
    i64 microseconds = stamp / 1000 + (stamp % 1000 >= 500) - (stamp % 1000 < -500);
    u64 magnitude = microseconds < 0 ? -(u64)microseconds : (u64)microseconds;
    if (microseconds < 0)
        *(*out)++ = '-';
    put_whole(out, magnitude / 1000000);
    u64 digits = digits_of((u32)(magnitude % 1000000));
    *(*out)++ = '.';
    digits >>= 16;
    memcpy(*out, &digits, 8);
    *out += 6;
}

static inline void put_addresses(u8 **out, u32 identifier)
{
    PUT(out, ", \"priority\": ");
    *(*out)++ = '0' + (u8)(identifier >> 26 & 7);
    PUT(out, ", \"source\": ");
    put_whole(out, identifier & 0xFF);
    PUT(out, ", \"destination\": ");
    put_whole(out, (identifier >> 16 & 0xFF) < 240 ? identifier >> 8 & 0xFF : 255);
    PUT(out, ", ");
}

/* The next line of a table, with all that stands before its fields. */
static inline void put_line(Line *line, const Table *table, const Py_buffer *columns, i64 day, bool timed)
{
    i64 row = table->next, stamp = ((const i64 *)columns[STAMP].buf)[row];
    const u8 *payloads = columns[PAYLOADS].buf;
    line->payload = payloads + table->width * row;
    line->readable = payloads + table->width * table->rows;
    line->length = ((const i64 *)columns[LENGTHS].buf)[row];
    line->at = 0;
    if (line->length < 0 || line->length > table->width) {
        line->stop = BY_HAND;
        return;
    }
    if (!room(line, table->head_size + 2 * line->length))
        return;
    put_time(&line->out, !timed || stamp == INT64_MIN ? INT64_MIN : (i64)((u64)stamp + (u64)day));
    put_addresses(&line->out, ((const u32 *)columns[IDENTIFIER].buf)[row]);
    put(&line->out, line->known->texts + table->head, table->head_size);
    put_hexadecimal(&line->out, line->payload, line->length);
    if (table->known)
        put_fields(line, table);
    else
        PUT(&line->out, "\"}\n");
}

/* What is not in the steps' own place, or longer than there is. */
static bool in_range(const Step *step, i64 number, const Known *known, i64 slots)
{
    i64 codes = step->kind == CODE || step->kind == VALUE ? (i64)1 << (step->bits & 63) : 0;
    if (step->kind < 0 || step->kind >= KINDS || step->text < 0 || step->size < 0 || step->least < 0
        || step->size > known->texts_size - SLACK - step->text || step->slots < 0 || codes > slots - step->slots)
        return false;
    switch (step->kind) {
    case NUMBER:
        return step->bits > 0 && step->bits + (step->offset & 7) <= 64 && step->places >= 0 && step->places <= 16
               && step->inverse > 0 && step->most >= 0 && step->offset >= 0 && step->need >= step->offset + step->bits;
    case COUNT:
        return step->bits > 0 && step->bits + (step->offset & 7) <= 64 && step->counter >= 0 && step->counter < 2
               && step->offset >= 0 && step->need >= step->offset + step->bits;
    case BITS:
        return step->bits > 0 && step->bits <= 57 && step->offset >= 0 && step->need >= step->offset + step->bits;
    case CODE:
        return step->bits > 0 && step->bits <= 16 && step->offset >= 0 && step->most >= step->offset + step->bits;
    case VALUE:
        return step->bits > 0 && step->bits <= 16;
    case HEXADECIMAL:
    case ASCII:
        return step->bits >= 0 && step->offset >= 0;
    case ITEMS:
        return step->steps >= 0 && step->steps < known->steps - number && step->counter >= -1 && step->counter < 2
               && step->size > 1;
    }
    return true;
}

/* -1 with an exception if something is not where it is said to be. */
static int check(const Known *known, i64 slots, const Table *tables, i64 count, const Py_buffer *columns)
{
    for (i64 each = 0; each < known->steps; each++)
        if (!in_range(&known->all[each], each, known, slots)) {
            PyErr_Format(PyExc_ValueError, "steps: number %lld is out of range", (long long)each);
            return -1;
        }
    for (i64 each = 0; each < count; each++) {
        const Table *table = &tables[each];
        const Py_buffer *of = columns + COLUMNS * each;
        if (table->step < 0 || table->steps < 0 || table->steps > known->steps - table->step || table->head < 0
            || table->head_size < 0 || table->head_size > known->texts_size - SLACK - table->head || table->width < 0
            || table->next < 0) {
            PyErr_Format(PyExc_ValueError, "tables: number %lld is out of range", (long long)each);
            return -1;
        }
        if (enough(&of[STAMP], table->rows, 8, "stamp") || enough(&of[IDENTIFIER], table->rows, 4, "identifier")
            || enough(&of[LENGTHS], table->rows, 8, "lengths")
            || (table->width && enough(&of[PAYLOADS], table->rows, table->width, "payloads")))
            return -1;
    }
    return 0;
}

/* Where the page is: the frame that is next, the bytes that are written, the line made before and its place. */
typedef struct {
    i64 frame, written, made, place;
} State;

enum { TEXTS, SLOTS, STEPS, OWNERS, MADE, SIZES, TABLES, PAGE, STATE, ALL };

static int write_page(const Py_buffer *views, const Py_buffer *columns, i64 day, bool timed, Line *line)
{
    const i32 *owners = views[OWNERS].buf;
    const i64 frames = views[OWNERS].len / 4, lines = views[SIZES].len / 8, *sizes = views[SIZES].buf;
    const i64 tables = views[TABLES].len / (i64)sizeof(Table);
    Table *all = views[TABLES].buf;
    State *state = views[STATE].buf;
    u8 *page = views[PAGE].buf;
    line->end = page + views[PAGE].len;
    line->stop = DONE;
    for (; state->frame < frames; state->frame++) {
        i32 owner = owners[state->frame];
        line->out = page + state->written;
        if (owner > 0 && owner <= tables && all[owner - 1].next < all[owner - 1].rows) {
            put_line(line, &all[owner - 1], columns + COLUMNS * (owner - 1), day, timed);
            if (line->stop)
                return 0;
            all[owner - 1].next++;
        } else if (owner < 0 && state->made < lines && sizes[state->made] >= 0
                   && sizes[state->made] <= views[MADE].len - state->place) {
            i64 size = sizes[state->made];
            if (!room(line, size))
                return 0;
            memcpy(line->out, (const u8 *)views[MADE].buf + state->place, (size_t)size);
            line->out += size;
            state->made++;
            state->place += size;
        } else if (owner) {
            return -1;
        }
        state->written = line->out - page;
    }
    return 0;
}

/* (texts, slots, steps, owners, made, sizes, tables, page, state, columns, day, timed) -> (why it stopped, step, code).
   Lines of the frames from `state` on: those of table n + 1 by its steps, -1 what is next of `made`, 0 nothing. */
PyObject *json_lines(PyObject *module, PyObject *arguments)
{
    PyObject *objects[ALL], *list, *result = NULL;
    Py_buffer views[ALL], *columns = NULL;
    Buffers buffers, of_tables = {NULL, 0};
    long long day;
    int timed, fault = 0;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOOOOO!Lp", &objects[TEXTS], &objects[SLOTS], &objects[STEPS],
                          &objects[OWNERS], &objects[MADE], &objects[SIZES], &objects[TABLES], &objects[PAGE],
                          &objects[STATE], &PyList_Type, &list, &day, &timed)
        || take_buffers(&buffers, views, objects, ALL, TABLES))
        return NULL;
    i64 tables = views[TABLES].len / (i64)sizeof(Table), slots = views[SLOTS].len / 8;
    Known known = {views[TEXTS].buf, views[TEXTS].len, views[SLOTS].buf, views[STEPS].buf,
                   views[STEPS].len / (i64)sizeof(Step)};
    if (enough(&views[STATE], 1, sizeof(State), "state"))
        goto end;
    const State *state = views[STATE].buf;
    if (PyList_Size(list) != COLUMNS * tables || state->frame < 0 || state->written < 0
        || state->written > views[PAGE].len || state->made < 0 || state->place < 0 || state->place > views[MADE].len) {
        PyErr_SetString(PyExc_ValueError, "columns or state: out of range");
        goto end;
    }
    columns = malloc((size_t)(COLUMNS * tables + 1) * sizeof(Py_buffer));
    PyObject **of = malloc((size_t)(COLUMNS * tables + 1) * sizeof(PyObject *));
    for (i64 each = 0; of && each < COLUMNS * tables; each++)
        of[each] = PyList_GetItem(list, (Py_ssize_t)each);
    if (!columns || !of)
        PyErr_NoMemory();
    else if (!take_buffers(&of_tables, columns, of, (int)(COLUMNS * tables), (int)(COLUMNS * tables))
             && !check(&known, slots, views[TABLES].buf, tables, columns)) {
        Line line = {.known = &known};
        Py_BEGIN_ALLOW_THREADS
        fault = write_page(views, columns, day, timed, &line);
        Py_END_ALLOW_THREADS
        if (fault)
            PyErr_SetString(PyExc_ValueError, "owners: a line that is not there");
        else
            result = Py_BuildValue("iLL", line.stop, (long long)line.step, (long long)line.code);
    }
    free(of);
end:
    give_buffers_back(&of_tables);
    free(columns);
    give_buffers_back(&buffers);
    return result;
}
