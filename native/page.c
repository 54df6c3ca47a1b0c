/* Messages to lines of JSON; see timonel/recording/sinks/line_steps.py, which says what the steps are made of.

       {"time": 1669809600.001488, "priority": 2, "source": 204, "destination": 255, "pgn": 127250, "name": ...}

   A line is written from left to right, as its payload is read. A code that was not met before stops the page: the
   caller finds its text and goes on from there. A line with something that steps cannot write is left out, and told. */
#include "kernels.h"

enum { TEXT, NUMBER, CODE, HEXADECIMAL, ASCII, BITS, GO, COUNT, ITEMS, LAU, LZ, VALUE, UNTOLD, KINDS };
enum { DONE, ROOM, NEW_CODE, BY_HAND }; /* why a line stops, and the page but for the last */
enum { SLACK = 64, LONGEST = 512 }; /* bytes behind a text, of any kind; and what a step needs but for its texts */
enum { FAR = 1 << 24 };             /* no place in a payload is so far away */

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
    const u8 *end; /* of the page */
    int stop;
    i64 step, code; /* what stopped it */
} Line;

static const u64 TENS[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000, 1000000000, 10000000000,
                           100000000000, 1000000000000, 10000000000000, 100000000000000, 1000000000000000,
                           10000000000000000, 100000000000000000, 1000000000000000000};

static inline bool room(Line *line, const u8 *out, i64 size)
{
    if (line->end - out >= size + LONGEST)
        return true;
    line->stop = ROOM;
    return false;
}

/* What puts something at `out` returns where it ends, so that this never waits for memory. */

/* Up to 31 bytes too many are written, and read. */
static inline u8 *put(u8 *out, const u8 *text, i64 size)
{
    for (i64 done = 0; done < size; done += 32)
        memcpy(out + done, text + done, 32);
    return out + size;
}

#define PUT(out, text) ((u8 *)memcpy(out, text, sizeof(text) - 1) + sizeof(text) - 1)

static inline u8 *put_name(const Line *line, const Step *step, u8 *out)
{
    return put(out, line->known->texts + step->text, step->size);
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

static inline u8 *put_whole(u8 *out, u64 number)
{
    if (number >= 100000000) {
        u64 high = number / 100000000;
        if (high >= 100000000) {
            u64 digits = digits_of((u32)(high / 100000000));
            int zeros = zeros_before(digits);
            store8(out, digits >> 8 * zeros);
            store8(out + 8 - zeros, digits_of((u32)(high % 100000000)));
            out += 16 - zeros;
        } else {
            u64 digits = digits_of((u32)high);
            int zeros = zeros_before(digits);
            store8(out, digits >> 8 * zeros);
            out += 8 - zeros;
        }
        store8(out, digits_of((u32)(number % 100000000)));
        return out + 8;
    }
    u64 digits = digits_of((u32)number);
    int zeros = zeros_before(digits);
    store8(out, digits >> 8 * zeros);
    return out + 8 - zeros;
}

/* number / 10 ** places below 0.0001. */
static u8 *put_small(u8 *out, u64 number, int places)
{
    u8 digits[20], *end = digits + sizeof digits, *first = end;
    while (!(number % 10))
        number /= 10, places--;
    for (; number; number /= 10)
        *--first = '0' + (u8)(number % 10);
    int exponent = places + 1 - (int)(end - first);
    *out++ = *first++;
    if (first < end)
        *out++ = '.';
    while (first < end)
        *out++ = *first++;
    out = PUT(out, "e-");
    *out++ = '0' + (u8)(exponent / 10);
    *out++ = '0' + (u8)(exponent % 10);
    return out;
}

/* number / 10 ** places, less than 10 ** 16 and with 1 to 16 places, as Python prints it: that of all decimals that are
   read as the same float which has the fewest digits. */
static inline u8 *put_decimal(u8 *out, u64 number, int places)
{
    if (places > 4 && number && number < TENS[places - 4])
        return put_small(out, number, places);
    if (number < 100000000 && places < 8) {
        u64 digits = digits_of((u32)number);
        int first = zeros_before(digits), point = 8 - places, behind = places - zeros_behind(digits);
        if (first > point - 1)
            first = point - 1;
        store8(out, digits >> 8 * first);
        out += point - first;
        *out++ = '.';
        store8(out, digits >> 8 * point);
        return out + (behind > 1 ? behind : 1);
    }
    u128 digits = sixteen_digits(number);
    u64 high = (u64)digits, low = (u64)(digits >> 64);
    int first = zeros_before(high), point = 16 - places, behind = places - zeros_behind(low);
    if (first == 7 && high >> 56 == '0')
        first = 8 + zeros_before(low);
    if (low == REPEATED('0'))
        behind = places - 8 - zeros_behind(high);
    if (first >= point) {
        *out++ = '0';
    } else {
        store16(out, digits >> 8 * first);
        out += point - first;
    }
    *out++ = '.';
    store16(out, digits >> 8 * point);
    return out + (behind > 1 ? behind : 1);
}

/* The same for a float from 0.1 to less than 1e15: 15 digits are enough, or the 16 or 17 that are nearest. */
static u8 *put_float(u8 *out, double value)
{
    int places = 15;
    for (u64 whole = (u64)value; whole; whole /= 10)
        places--;
    u64 fifteen = (u64)(value * (double)TENS[places] + 0.5);
    if ((double)fifteen / (double)TENS[places] == value) {
        return put_decimal(out, places ? fifteen : 10 * fifteen, places ? places : 1);
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
    out = put_whole(out, number / TENS[places]);
    *out++ = '.';
    u64 rest = number % TENS[places];
    for (int place = places; place--; rest /= 10)
        out[place] = '0' + (u8)(rest % 10);
    return out + places;
}
static const char HEX_DIGITS[] = "0123456789ABCDEF";

/* Eight digits of four bytes. */
static inline u64 hexadecimal(u64 bytes)
{
    bytes = (bytes | bytes << 16) & 0x0000FFFF0000FFFFu;
    bytes = (bytes | bytes << 8) & 0x00FF00FF00FF00FFu;
    u64 digits = (bytes >> 4 & 0x000F000F000F000Fu) | (bytes & 0x000F000F000F000Fu) << 8;
    return digits + REPEATED('0') + ((digits + REPEATED(6)) >> 4 & REPEATED(1)) * ('A' - '0' - 10);
}

static inline u8 *put_hexadecimal(u8 *out, const u8 *data, i64 count)
{
    i64 byte = 0;
    for (; byte + 4 <= count; byte += 4)
        store8(out + 2 * byte, hexadecimal(load4(data + byte)));
    for (; byte < count; byte++) {
        out[2 * byte] = (u8)HEX_DIGITS[data[byte] >> 4];
        out[2 * byte + 1] = (u8)HEX_DIGITS[data[byte] & 15];
    }
    return out + 2 * count;
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

static inline u8 *put_number(Line *line, const Step *step, u8 *out)
{
    i64 raw;
    if (!number_of(line, step, &raw))
        return out;
    out = put_name(line, step, out);
    i64 value = (i64)((step->places ? (u64)raw : (u64)raw * (u64)step->factor) + (u64)step->add);
    bool negative = value < 0 && (step->sign || step->add);
    u64 magnitude = negative ? -(u64)value : (u64)value;
    if (negative)
        *out++ = '-';
    if (!step->places)
        return put_whole(out, magnitude);
    if (magnitude <= (u64)step->most)
        return put_decimal(out, magnitude * (u64)step->factor, (int)step->places);
    double quotient = (double)magnitude / (double)step->inverse;
    if (quotient >= 0.1 && quotient < 1e15)
        return put_float(out, quotient);
    line->stop = BY_HAND;
    return out;
}

static inline void unknown(Line *line, const Step *step, u64 code)
{
    line->stop = NEW_CODE;
    line->step = step - line->known->all;
    line->code = (i64)code;
}

/* A text that was found for the code, with the name in it. */
static inline u8 *put_code(Line *line, const Step *step, u8 *out)
{
    if (!there(line, step->need))
        return out;
    if (!there(line, step->most)) { /* what else tells it */
        line->stop = BY_HAND;
        return out;
    }
    u64 code = raw_value(line, step), slot = line->known->slots[(u64)step->slots + code];
    i64 size = (i64)(slot & 0xFFFF), text = (i64)(slot >> 16);
    if (!slot)
        unknown(line, step, code);
    else if (text + size + SLACK > line->known->texts_size)
        line->stop = BY_HAND;
    else if (room(line, out, size))
        return put(out, line->known->texts + text, size);
    return out;
}

static inline i64 least_of(i64 one, i64 other) { return one < other ? one : other; }

static inline u8 *put_bytes(Line *line, const Step *step, u8 *out, i64 first, i64 count)
{
    if (count <= 0 || !room(line, out, 2 * count))
        return out;
    out = put_name(line, step, out);
    *out++ = '"';
    out = put_hexadecimal(out, line->payload + first, count);
    *out++ = '"';
    return out;
}

/* Bits between bytes, as the bytes of their number. */
static inline u8 *put_bits(Line *line, const Step *step, u8 *out)
{
    if (!there(line, step->need))
        return out;
    u64 word = raw_value(line, step);
    out = put_name(line, step, out);
    *out++ = '"';
    out = put_hexadecimal(out, (const u8 *)&word, (step->bits + 7) / 8);
    *out++ = '"';
    return out;
}

/* Text of ASCII only; what is not of it, or has to be escaped as a number, is written by hand. */
static inline u8 *put_text(Line *line, const Step *step, u8 *out, const u8 *text, i64 size)
{
    if (!size || !room(line, out, 2 * size))
        return out;
    out = put_name(line, step, out);
    *out++ = '"';
    for (i64 each = 0; each < size; each++) {
        if (text[each] < ' ')
            line->stop = BY_HAND;
        if (text[each] == '"' || text[each] == '\\')
            *out++ = '\\';
        *out++ = text[each];
    }
    *out++ = '"';
    return out;
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
static inline u8 *put_words(Line *line, const Step *step, u8 *out, const u8 *text, i64 size)
{
    if (!is_ascii(text, size)) {
        line->stop = BY_HAND;
        return out;
    }
    while (size && (text[size - 1] == ' ' || (text[size - 1] >= 9 && text[size - 1] <= 13)
                    || (text[size - 1] >= 28 && text[size - 1] <= 31)))
        size--;
    return put_text(line, step, out, text, size);
}

/* Up to its padding. */
static inline u8 *put_fixed_text(Line *line, const Step *step, u8 *out)
{
    i64 first = line->at + step->offset / 8, size = least_of(step->bits / 8, line->length - first);
    if (size <= 0)
        return out;
    const u8 *text = line->payload + first;
    return put_words(line, step, out, text, until(text, until(text, until(text, size, 0xFF), 0), '@'));
}

/* Text with a length, which counts itself, and what kind it is of. */
static inline u8 *put_lau(Line *line, const Step *step, u8 *out)
{
    if (line->length < line->at + 2) {
        line->at = line->length;
        return out;
    }
    const u8 *text = line->payload + line->at;
    i64 whole = text[0] > 2 ? text[0] : 2, size = least_of(whole, line->length - line->at) - 2;
    line->at += whole;
    if (text[1] > 1)
        return out;
    if (!text[1]) { /* two bytes a character */
        if (size > 1)
            line->stop = BY_HAND;
        return out;
    }
    text += 2;
    size = until(text, size, 0xFF);
    if (!is_ascii(text, size)) {
        line->stop = BY_HAND;
        return out;
    }
    size = until(text, size, 0);
    while (size && strchr("@ \t\r\n", text[size - 1]))
        size--;
    return put_text(line, step, out, text, size);
}

/* Text with a length, and a zero behind it. */
static inline u8 *put_lz(Line *line, const Step *step, u8 *out)
{
    if (line->length <= line->at)
        return out;
    const u8 *text = line->payload + line->at + 1;
    i64 whole = line->payload[line->at], size = least_of(whole, line->length - line->at - 1);
    line->at += whole + 2;
    return put_words(line, step, out, text, until(text, size, 0));
}

/* A value behind its key: which step writes it is found by what stands before it. */
static inline u8 *put_value(Line *line, const Step *step, u8 *out)
{
    i64 place = 8 * line->at + step->offset;
    if (place < 0 || place + step->bits > 8 * line->length) {
        line->stop = BY_HAND;
        return out;
    }
    u64 code = raw_value(line, step), slot = line->known->slots[(u64)step->slots + code];
    if (!slot || slot > (u64)line->known->steps) {
        unknown(line, step, code);
        return out;
    }
    const Step *told = &line->known->all[slot - 1];
    i64 left = line->length - line->at, count = least_of(told->least, left);
    if (!room(line, out, told->size))
        return out;
    if (told->least > left || told->kind == HEXADECIMAL)
        out = put_bytes(line, told, out, line->at, count);
    else if (told->kind == NUMBER)
        out = put_number(line, told, out);
    else if (told->kind == CODE)
        out = put_code(line, told, out);
    else if (told->kind == ASCII)
        out = put_fixed_text(line, told, out);
    else
        line->stop = BY_HAND;
    line->at += count;
    return out;
}

/* One step of a line or of an item. */
static inline u8 *put_step(Line *line, const Step *step, u8 *out)
{
    i64 raw;
    if (!room(line, out, step->size))
        return out;
    switch (step->kind) {
    case TEXT:
        out = put_name(line, step, out);
        break;
    case NUMBER:
        out = put_number(line, step, out);
        break;
    case CODE:
        out = put_code(line, step, out);
        break;
    case HEXADECIMAL:
        out = put_bytes(line, step, out, line->at + step->offset / 8,
                  least_of(step->bits / 8, line->length - line->at - step->offset / 8));
        break;
    case BITS:
        out = put_bits(line, step, out);
        break;
    case ASCII:
        out = put_fixed_text(line, step, out);
        break;
    case GO:
        line->at += step->least;
        break;
    case COUNT:
        line->counts[step->counter] = number_of(line, step, &raw) ? raw : 0;
        break;
    case LAU:
        out = put_lau(line, step, out);
        break;
    case LZ:
        out = put_lz(line, step, out);
        break;
    case VALUE:
        out = put_value(line, step, out);
        break;
    default:
        line->stop = BY_HAND;
    }
    return out;
}

static inline u8 *put_items(Line *line, const Step *step, u8 *out)
{
    i64 count = step->counter < 0 ? step->most : line->counts[step->counter], items = 0;
    for (; items < count && line->at + step->least <= line->length && !line->stop; items++) {
        if (!room(line, out, step->size))
            return out;
        if (items)
            out = PUT(out, ", {");
        else
            out = put_name(line, step, out);
        u8 *begin = out, kept[2] = {begin[-2], begin[-1]};
        out -= 2; /* the first field has no comma before it */
        for (i64 each = 1; each <= step->steps && !line->stop; each++)
            out = put_step(line, step + each, out);
        memcpy(begin - 2, kept, 2);
        if (out < begin)
            out = begin;
        *out++ = '}';
    }
    if (items)
        *out++ = ']';
    return out;
}

static inline u8 *put_fields(Line *line, const Table *table, u8 *out)
{
    static const u8 fields[] = "\", \"fields\": {";
    u8 *begin = out;
    out += sizeof(fields) - 3;
    const Step *steps = line->known->all + table->step;
    for (i64 each = 0; each < table->steps && !line->stop; each++) {
        if (steps[each].kind == ITEMS) {
            out = put_items(line, &steps[each], out);
            each += steps[each].steps;
        } else {
            out = put_step(line, &steps[each], out);
        }
    }
    memcpy(begin, fields, sizeof(fields) - 1);
    if (out < begin + sizeof(fields) - 1)
        out = begin + sizeof(fields) - 1;
    return PUT(out, "}}\n");
}

/* Nanoseconds, to the microsecond; the smallest number is none. */
static inline u8 *put_time(u8 *out, i64 stamp)
{
    out = PUT(out, "{\"time\": ");
    if (stamp == INT64_MIN)
        return PUT(out, "null");
    i64 microseconds = stamp / 1000 + (stamp % 1000 >= 500) - (stamp % 1000 < -500);
    u64 magnitude = microseconds < 0 ? -(u64)microseconds : (u64)microseconds;
    if (microseconds < 0)
        *out++ = '-';
    out = put_whole(out, magnitude / 1000000);
    *out++ = '.';
    store8(out, digits_of((u32)(magnitude % 1000000)) >> 16);
    return out + 6;
}

static inline u8 *put_addresses(u8 *out, u32 identifier)
{
    out = PUT(out, ", \"priority\": ");
    *out++ = '0' + (u8)(identifier >> 26 & 7);
    out = PUT(out, ", \"source\": ");
    out = put_whole(out, identifier & 0xFF);
    out = PUT(out, ", \"destination\": ");
    out = put_whole(out, (identifier >> 16 & 0xFF) < 240 ? identifier >> 8 & 0xFF : 255);
    return PUT(out, ", ");
}

/* The next line of a table, with all that stands before its fields. */
static inline u8 *put_line(Line *line, const Table *table, u8 *out, const Py_buffer *columns, i64 day, bool timed)
{
    i64 row = table->next, stamp = ((const i64 *)columns[STAMP].buf)[row];
    const u8 *payloads = columns[PAYLOADS].buf;
    line->payload = payloads + table->width * row;
    line->readable = payloads + table->width * table->rows;
    line->length = ((const i64 *)columns[LENGTHS].buf)[row];
    line->at = 0;
    if (line->length < 0 || line->length > table->width) {
        line->stop = BY_HAND;
        return out;
    }
    if (!room(line, out, table->head_size + 2 * line->length))
        return out;
    out = put_time(out, !timed || stamp == INT64_MIN ? INT64_MIN : (i64)((u64)stamp + (u64)day));
    out = put_addresses(out, ((const u32 *)columns[IDENTIFIER].buf)[row]);
    out = put(out, line->known->texts + table->head, table->head_size);
    out = put_hexadecimal(out, line->payload, line->length);
    return table->known ? put_fields(line, table, out) : PUT(out, "\"}\n");
}

/* What is not in the steps' own place, or longer than there is. */
static bool in_range(const Step *step, i64 number, const Known *known, i64 slots)
{
    if (step->kind < 0 || step->kind >= KINDS || step->text < 0 || step->size < 0
        || step->size > known->texts_size - SLACK - step->text || step->bits < 0 || step->bits > FAR
        || step->offset < -FAR || step->offset > FAR || step->least < 0 || step->least > FAR)
        return false;
    if ((step->kind == CODE || step->kind == VALUE)
        && (step->bits > 16 || step->slots < 0 || ((i64)1 << step->bits) > slots - step->slots))
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
        return step->bits > 0 && step->offset >= 0 && step->most >= step->offset + step->bits;
    case VALUE:
        return step->bits > 0;
    case HEXADECIMAL:
    case ASCII:
        return step->offset >= 0;
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

/* Where the page is: the frame that is next, the bytes that are written, the next line that was made before and its
   place, and how many lines were left out. */
typedef struct {
    i64 frame, written, made, place, gaps;
} State;

/* A line that was left out, and where. */
typedef struct {
    i64 table, row, place;
} Gap;

enum { TEXTS, SLOTS, STEPS, OWNERS, MADE, SIZES, TABLES, PAGE, STATE, GAPS, ALL };

/* All in one function, it takes a sixth less time. */
__attribute__((flatten)) static int write_page(const Py_buffer *views, const Py_buffer *columns, i64 day, bool timed, Line *line)
{
    const i32 *owners = views[OWNERS].buf;
    const i64 frames = views[OWNERS].len / 4, lines = views[SIZES].len / 8, *sizes = views[SIZES].buf;
    const i64 tables = views[TABLES].len / (i64)sizeof(Table);
    Table *all = views[TABLES].buf;
    State *state = views[STATE].buf;
    Gap *gaps = views[GAPS].buf;
    u8 *page = views[PAGE].buf;
    line->end = page + views[PAGE].len;
    line->stop = DONE;
    for (; state->frame < frames; state->frame++) {
        i32 owner = owners[state->frame];
        u8 *out = page + state->written;
        if (owner > 0 && owner <= tables && all[owner - 1].next < all[owner - 1].rows) {
            out = put_line(line, &all[owner - 1], out, columns + COLUMNS * (owner - 1), day, timed);
            if (line->stop == BY_HAND) {
                gaps[state->gaps++] = (Gap){owner - 1, all[owner - 1].next, state->written};
                out = page + state->written;
                line->stop = DONE;
            }
            if (line->stop)
                return 0;
            all[owner - 1].next++;
        } else if (owner < 0 && state->made < lines && sizes[state->made] >= 0
                   && sizes[state->made] <= views[MADE].len - state->place) {
            i64 size = sizes[state->made];
            if (!room(line, out, size))
                return 0;
            memcpy(out, (const u8 *)views[MADE].buf + state->place, (size_t)size);
            out += size;
            state->made++;
            state->place += size;
        } else if (owner) {
            return -1;
        }
        state->written = out - page;
    }
    return 0;
}

/* (texts, slots, steps, owners, made, sizes, tables, page, state, gaps, columns, day, timed) -> (why it stopped, step,
   code). Lines of the frames from `state` on: those of table n + 1 by its steps, -1 what is next of `made`, 0 nothing. */
PyObject *json_lines(PyObject *module, PyObject *arguments)
{
    PyObject *objects[ALL], *list, *result = NULL;
    Py_buffer views[ALL], *columns = NULL;
    Buffers buffers, of_tables = {NULL, 0};
    long long day;
    int timed, fault = 0;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOOOOOO!Lp", &objects[TEXTS], &objects[SLOTS], &objects[STEPS],
                          &objects[OWNERS], &objects[MADE], &objects[SIZES], &objects[TABLES], &objects[PAGE],
                          &objects[STATE], &objects[GAPS], &PyList_Type, &list, &day, &timed)
        || take_buffers(&buffers, views, objects, ALL, TABLES))
        return NULL;
    i64 tables = views[TABLES].len / (i64)sizeof(Table), slots = views[SLOTS].len / 8;
    Known known = {views[TEXTS].buf, views[TEXTS].len, views[SLOTS].buf, views[STEPS].buf,
                   views[STEPS].len / (i64)sizeof(Step)};
    if (enough(&views[STATE], 1, sizeof(State), "state")
        || enough(&views[GAPS], views[OWNERS].len / 4, sizeof(Gap), "gaps"))
        goto end;
    const State *state = views[STATE].buf;
    if (PyList_Size(list) != COLUMNS * tables || state->frame < 0 || state->written < 0
        || state->written > views[PAGE].len || state->made < 0 || state->place < 0 || state->place > views[MADE].len
        || state->gaps < 0 || state->gaps > state->frame) {
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
