/* NMEA 0183 text to columns; see timonel/recording/nmea0183.py, sentence_lines.py, fast_nmea0183.py and
   coded_sentences.py, which say what all of it means. Around the text there is room to read a word anywhere. */
#include <float.h>

#include "kernels.h"

#if FLT_EVAL_METHOD != 0
#error "quotients are rounded twice here"
#endif

enum { PADDING = 16 };

static const i64 NO_STAMP = INT64_MIN;
static const u64 WHOLE_POWERS[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
static const double POWERS[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8};

static inline u64 first_bytes(u64 word, i64 count) { return count < 8 ? word & (((u64)1 << 8 * count) - 1) : word; }

/* Not zero if one of the bytes is not printable. */
static inline u64 unprintable(u64 word)
{
    u64 low = word & REPEATED(0x7F);
    return (word | (low + REPEATED(1)) | ~(low + REPEATED(0x60))) & REPEATED(0x80);
}

/* The XOR of the bytes, which are more than none; -1 if one is not printable. */
static inline int sum(const u8 *at, const u8 *end)
{
    u64 all = 0, other = 0;
    for (; end - at > 8; at += 8) {
        all ^= load8(at);
        other |= unprintable(load8(at));
    }
    u64 last = first_bytes(load8(at), end - at);
    other |= unprintable(last | (REPEATED(' ') ^ first_bytes(REPEATED(' '), end - at)));
    all ^= last;
    all ^= all >> 32;
    all ^= all >> 16;
    return other ? -1 : (int)((all ^ all >> 8) & 0xFF);
}

static inline int hexadecimal(u8 letter)
{
    u8 digit = letter - '0', capital = (letter | 0x20) - 'a';
    return digit < 10 ? digit : capital < 6 ? capital + 10 : 0x100;
}

/* Whether a line, without its end, goes from `$` or `!` to a right check sum, and is printable. */
static inline bool plain(const u8 *line, const u8 *end)
{
    if (end - line < 4 || (line[0] != '$' && line[0] != '!') || end[-3] != '*')
        return false;
    return sum(line, end) == (line[0] ^ '*' ^ end[-2] ^ end[-1] ^ (hexadecimal(end[-2]) << 4 | hexadecimal(end[-1])));
}

/* Up to fifteen digits behind those that `number` has; how many. */
static inline int more_digits(const u8 *at, u64 *number)
{
    int count = 0;
    for (; count < 15 && (u8)(at[count] - '0') < 10; count++)
        *number = *number * 10 + (u64)(at[count] - '0');
    return count;
}

/* Seconds, or milliseconds if they are very many, in ns, of which the reader of single lines keeps whole microseconds;
   NO_STAMP if no recording can be of that time. */
static inline i64 in_ns(double time)
{
    double seconds = time >= 1e11 ? time / 1000.0 : time;
    if (seconds >= 8589934592.0)
        return NO_STAMP;
    volatile double product = seconds * 1e6; /* rounded before it is used */
    double microseconds = product;
    i64 whole = (i64)microseconds;
    double rest = microseconds - (double)whole;
    return (whole + (rest > 0.5 || (rest == 0.5 && (whole & 1)))) * 1000;
}

/* Where the sentence begins behind what ends a time, a blank or `;source;`; NULL if it is neither. */
static inline const u8 *behind_source(const u8 *at, const u8 *end)
{
    if (*at == ' ')
        return at + 1;
    if (*at++ != ';')
        return NULL;
    while (at < end && *at >= ' ' && *at <= '~' && *at != ';' && *at != '$' && *at != '!' && *at != '\\')
        at++;
    return *at == ';' ? at + 1 : NULL;
}

/* Behind `1402160417499;N;` or `1402160417.499 `; NULL if it is nothing of the kind. */
static inline const u8 *behind_count(const u8 *at, const u8 *end, i64 *stamp)
{
    u64 number = 0;
    int digits = more_digits(at, &number), places = 0;
    at += digits;
    if (digits < 1 || digits == 11 || digits > 13)
        return NULL;
    if (digits <= 10 && *at == '.') {
        places = more_digits(at + 1, &number);
        at += 1 + places;
        if (places < 1 || places > 8 || digits + places > 15)
            return NULL;
    }
    *stamp = in_ns((double)(i64)number / POWERS[places]);
    return *stamp == NO_STAMP ? NULL : behind_source(at, end);
}

static const int DAYS_BEFORE[] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334, 365};

/* Days since 1970, up to 2099; -1 if there is no such day. */
static inline i64 days_of(i64 day, i64 month, i64 year)
{
    if (month < 1 || month > 12 || year < 1970 || year > 2099)
        return -1;
    bool leap = year % 4 == 0;
    i64 days = DAYS_BEFORE[month] - DAYS_BEFORE[month - 1] + (leap && month == 2);
    if (day < 1 || day > days)
        return -1;
    return (year - 1970) * 365 + (year - 1969) / 4 + DAYS_BEFORE[month - 1] + (leap && month > 2) + day - 1;
}

/* Behind `2023-09-02T12:41:35.168Z `, or with a blank in it, without a fraction, without the Z; NULL if it is nothing
   of the kind. */
static inline const u8 *behind_date(const u8 *at, const u8 *end, i64 *stamp)
{
    if (end - at < 20)
        return NULL;
    u64 first = load8(at) ^ 0x2D30302D30303030u;                                   /* 0000-00- */
    u64 second = load8(at + 8) ^ 0x30303A3030543030u ^ (u64)(at[10] == ' ' ? 'T' ^ ' ' : 0) << 16; /* 00T00:00 */
    if (no_digits(first) | no_digits(second) | (first & 0xFF0000FF00000000u) | (second & 0x0000FF0000FF0000u))
        return NULL;
    u32 month = eight_digits(first), minutes = eight_digits(second); /* 2023 0 09 0, 02 0 12 0 41 */
    i64 days = days_of(minutes / 1000000, month / 10 % 100, month / 10000);
    i64 hour = minutes / 1000 % 100, minute = minutes % 100;
    u64 seconds = 0, fraction = 0;
    if (days < 0 || hour >= 24 || minute >= 60 || at[16] != ':' || more_digits(at + 17, &seconds) != 2 || seconds >= 60)
        return NULL;
    int places = at[19] == '.' ? more_digits(at + 20, &fraction) : 0;
    at += at[19] == '.' ? 20 + places : 19;
    if (at[-1] == '.' || places > 8)
        return NULL;
    i64 whole = ((days * 24 + hour) * 60 + minute) * 60 + (i64)seconds;
    *stamp = in_ns((double)whole + (double)(i64)fraction / POWERS[places]);
    return behind_source(at + (*at == 'Z'), end);
}

/* Behind a TAG block, `\s:gps,c:1319460666*44\`, whose time is a whole number or missing; NULL
   if it is nothing of the kind. */
static inline const u8 *behind_tag(const u8 *line, const u8 *end, i64 *stamp)
{
    const u8 *item = line + 1, *close = memchr(item, '\\', (size_t)(end - item));
    if (!close || close - item < 4 || close[-3] != '*'
        || sum(item, close - 3) != (hexadecimal(close[-2]) << 4 | hexadecimal(close[-1])))
        return NULL;
    for (const u8 *stop; item < close - 3; item = stop + 1) {
        stop = memchr(item, ',', (size_t)(close - 3 - item));
        stop = stop ? stop : close - 3;
        if (item[0] != 'c' || item[1] != ':')
            continue;
        u64 number = 0;
        int digits = more_digits(item + 2, &number);
        *stamp = digits && item + 2 + digits == stop ? in_ns((double)(i64)number) : NO_STAMP;
        return *stamp == NO_STAMP ? NULL : close + 1;
    }
    return close + 1;
}

/* Where the sentence of a line begins, and its time; NULL if it has none that is plain. */
static inline const u8 *sentence_of(const u8 *line, const u8 *end, i64 *stamp)
{
    *stamp = NO_STAMP;
    const u8 *begin = line;
    if ((u8)(*line - '0') < 10)
        begin = line[4] == '-' ? behind_date(line, end, stamp) : behind_count(line, end, stamp);
    else if (*line == '\\')
        begin = behind_tag(line, end, stamp);
    return begin && plain(begin, end) ? begin : NULL;
}

/* (text, begin, end, behind, stamp, plain) -> None: where sentences, or other lines, begin, where their characters end,
   where the next lines begin, the sentences' times, and which lines have a plain one; int64, `plain` is uint8. */
PyObject *sentence_lines(PyObject *module, PyObject *arguments)
{
    PyObject *objects[6];
    Py_buffer views[6];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4],
                          &objects[5])
        || take_buffers(&buffers, views, objects, 6, 1))
        return NULL;
    i64 count = views[1].len / 8, line = 0;
    if (enough(&views[0], 2 * PADDING, 1, "text") || enough(&views[2], count, 8, "end")
        || enough(&views[3], count, 8, "behind") || enough(&views[4], count, 8, "stamp")
        || enough(&views[5], count, 1, "plain")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    const u8 *text = views[0].buf, *at = text + PADDING, *last = text + views[0].len - PADDING;
    i64 *begin = views[1].buf, *end = views[2].buf, *behind = views[3].buf, *stamp = views[4].buf;
    u8 *fine = views[5].buf;
    Py_BEGIN_ALLOW_THREADS
    for (; line < count; line++) {
        const u8 *feed = memchr(at, '\n', (size_t)(last - at));
        if (!feed)
            break;
        const u8 *stop = feed > at && feed[-1] == '\r' ? feed - 1 : feed;
        const u8 *sentence = sentence_of(at, stop, &stamp[line]);
        fine[line] = sentence != NULL;
        begin[line] = (sentence ? sentence : at) - text;
        end[line] = stop - text;
        behind[line] = feed + 1 - text;
        at = feed + 1;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (line < count) {
        PyErr_SetString(PyExc_ValueError, "text: fewer lines");
        return NULL;
    }
    Py_RETURN_NONE;
}

enum { HASHES = 1 << 15, SHORTEST = 10 /* $IIHDT,*hh */ };

static inline u32 hash(u64 letters)
{
    return (u32)((letters & 31) << 10 | (letters >> 8 & 31) << 5 | (letters >> 16 & 31));
}

/* (text, begin, end, by_hash, letters, codes) -> None: the number of each sentence's three letters, which `by_hash`
   (uint16) tells where `letters` (uint64) has them; 0 where it does not, and for other addresses. */
PyObject *sentence_codes(PyObject *module, PyObject *arguments)
{
    PyObject *objects[6];
    Py_buffer views[6];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4],
                          &objects[5])
        || take_buffers(&buffers, views, objects, 6, 5))
        return NULL;
    i64 count = views[1].len / 8, known = views[4].len / 8, row = 0;
    if (enough(&views[0], 2 * PADDING, 1, "text") || enough(&views[2], count, 8, "end")
        || enough(&views[3], HASHES, 2, "by_hash") || enough(&views[5], count, 2, "codes")) {
        give_buffers_back(&buffers);
        return NULL;
    }
    const u8 *text = views[0].buf;
    const i64 *begin = views[1].buf, *end = views[2].buf;
    const u16 *by_hash = views[3].buf;
    const u64 *names = views[4].buf;
    u16 *codes = views[5].buf;
    Py_BEGIN_ALLOW_THREADS
    for (; row < count && begin[row] >= 0 && begin[row] <= views[0].len - PADDING; row++) {
        u64 head = load8(text + begin[row]), letters = head >> 24 & 0xFFFFFF;
        u16 code = by_hash[hash(letters)];
        bool usual = (head >> 48 & 0xFF) == ',' && (head >> 8 & 0xFF) != 'P' && end[row] - begin[row] >= SHORTEST;
        codes[row] = usual && code < known && names[code] == letters ? code : 0;
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (row < count) {
        PyErr_SetString(PyExc_ValueError, "begin: a sentence that is not there");
        return NULL;
    }
    Py_RETURN_NONE;
}

/* (codes, ends, begin, end, line, stamp, to, to, to, to) -> None: the sentences in the order of their codes, those with
   one code in the order in which they were; the ones with code c end before ends[c]. int64, codes are uint16. */
PyObject *sentence_groups(PyObject *module, PyObject *arguments)
{
    enum { CODES, BEGIN, END, LINE, STAMP, ENDS, TO, ALL = TO + 4 };
    PyObject *objects[ALL];
    Py_buffer views[ALL];
    Buffers buffers;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOOOOOOOO", &objects[CODES], &objects[ENDS], &objects[BEGIN], &objects[END],
                          &objects[LINE], &objects[STAMP], &objects[TO], &objects[TO + 1], &objects[TO + 2],
                          &objects[TO + 3])
        || take_buffers(&buffers, views, objects, ALL, ENDS))
        return NULL;
    i64 count = views[CODES].len / 2, known = views[ENDS].len / 8;
    for (int each = BEGIN; each < ALL; each++)
        if (each != ENDS && enough(&views[each], count, 8, "begin, end, line, stamp")) {
            give_buffers_back(&buffers);
            return NULL;
        }
    const u16 *codes = views[CODES].buf;
    const i64 *begin = views[BEGIN].buf, *end = views[END].buf, *line = views[LINE].buf, *stamp = views[STAMP].buf;
    i64 *ends = views[ENDS].buf, *to_begin = views[TO].buf, *to_end = views[TO + 1].buf, *to_line = views[TO + 2].buf,
        *to_stamp = views[TO + 3].buf;
    u16 highest = 0;
    Py_BEGIN_ALLOW_THREADS
    for (i64 row = 0; row < count; row++)
        highest = codes[row] > highest ? codes[row] : highest;
    if (highest < known) {
        memset(ends, 0, 8 * (size_t)known);
        for (i64 row = 0; row < count; row++)
            ends[codes[row]]++;
        for (i64 code = 0, before = 0; code < known; code++) {
            i64 some = ends[code];
            ends[code] = before; /* until all are in their places: where the next one goes */
            before += some;
        }
        for (i64 row = 0; row < count; row++) {
            i64 at = ends[codes[row]]++;
            to_begin[at] = begin[row];
            to_end[at] = end[row];
            to_line[at] = line[row];
            to_stamp[at] = stamp[row];
        }
    }
    Py_END_ALLOW_THREADS
    give_buffers_back(&buffers);
    if (highest >= known) {
        PyErr_SetString(PyExc_ValueError, "ends: fewer than there are codes");
        return NULL;
    }
    Py_RETURN_NONE;
}

/* Sentences that are looked at together, a column after the other. */
enum { BLOCK = 128, MOST_FIELDS = 64, MOST_WIRES = 256 };

/* What becomes of a field, as in coded_sentences.py. */
enum { NUMBER, SIGNED, POSITION, TIME_OF_DAY, DATE, INTEGER, LETTER, STATUS, TEXT };

/* A column: from which field on, between which values, with which letters; and where its values go. */
typedef struct {
    int how, wire;
    double low, high;
    const char *letters;
    Py_ssize_t letter_count;
    void *values, *valid;
} Column;

/* Some sentences: `marks[wire][row]` is where a field begins, and the one behind it a character further than it ends;
   no field ends before it begins, where there is none. */
typedef struct {
    const u8 *text;
    i64 (*marks)[BLOCK];
    u8 *odd; /* of each sentence: a field is not as usual */
    int rows;
} Block;

typedef struct {
    const u8 *at;
    i64 size;
} Field;

typedef struct {
    u64 digits;     /* without the point */
    i64 places;     /* behind the point; -1 without one */
    bool negative;
} Decimal;

static const double NOTHING = __builtin_nan("");

/* The highest bit of each byte that is this one. */
static inline u64 bytes_that_are(u64 word, u8 byte)
{
    u64 other = word ^ REPEATED(byte), low = REPEATED(0x7F);
    return ~(((other & low) + low) | other | low);
}

static inline void split(const u8 *text, i64 at, i64 last, int wires, i64 *marks)
{
    int wire = 0;
    for (; at < last; at += 8) {
        u64 commas = first_bytes(bytes_that_are(load8(text + at), ','), last - at);
        for (; commas; commas &= commas - 1) {
            marks[BLOCK * wire] = at + (__builtin_ctzll(commas) >> 3) + 1;
            if (++wire > wires)
                return;
        }
    }
    for (; wire <= wires; wire++)
        marks[BLOCK * wire] = last + 1;
}

static inline Field field(const Block *block, int wire, int row)
{
    i64 begin = block->marks[wire][row];
    return (Field){block->text + begin, block->marks[wire + 1][row] - begin - 1};
}

static inline bool empty(Field field) { return field.size <= 0; }
static inline bool only(Field field, char letter) { return field.size == 1 && *field.at == (u8)letter; }
static inline bool none_or_only(Field field, char letter) { return empty(field) || only(field, letter); }

/* The first digits of a word, before which zeros come. */
static inline u64 digits_before(u64 word, i64 count)
{
    return (word ^ REPEATED('0')) << 4 * (8 - count) << 4 * (8 - count);
}

/* A number with a point and a minus sign or without: up to eight digits before the point and behind it, fifteen in all,
   so that whole number and power of ten are exact. */
static inline bool decimal(Field field, Decimal *found)
{
    found->negative = field.size > 0 && *field.at == '-';
    const u8 *at = field.at + found->negative;
    i64 size = field.size - found->negative;
    u64 head = load8(at), points = bytes_that_are(head, '.');
    i64 whole = points ? __builtin_ctzll(points) >> 3 : at[8] == '.' ? 8 : size;
    whole = whole < size ? whole : size;
    i64 behind = whole < size ? size - whole - 1 : 0;
    found->places = size - whole - 1;
    if (whole > 8 || behind > 8 || whole + behind <= 0)
        return false;
    u64 left = digits_before(head, whole), right = digits_before(load8(at + size - behind), behind);
    found->digits = eight_digits(left) * WHOLE_POWERS[behind] + eight_digits(right);
    return !(no_digits(left) | no_digits(right)) && found->digits < 1000000000000000u;
}

static inline double value_of(const Decimal *decimal)
{
    double value = (double)(i64)decimal->digits / POWERS[decimal->places > 0 ? decimal->places : 0];
    return decimal->negative ? -value : value;
}

static void numbers(const Column *column, const Block *block, double *values)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        Decimal number;
        values[row] = NOTHING;
        if (!empty(text)) {
            bool fine = decimal(text, &number);
            values[row] = fine ? value_of(&number) : NOTHING;
            block->odd[row] |= !(values[row] >= column->low && values[row] <= column->high);
        }
    }
    for (int row = 0; row < block->rows && column->letter_count; row++)
        block->odd[row] |= !none_or_only(field(block, column->wire + 1, row), column->letters[0]);
}

/* Degrees of `dddmm.mmmm`; not a number where there are none. */
static inline double degrees_of(double value)
{
    double degrees = (double)(i64)(value / 100.0);
    degrees -= degrees * 100.0 > value;
    double minutes = value - degrees * 100.0; /* the product is exact, fused or not */
    return minutes < 60.0 ? degrees + minutes / 60.0 : NOTHING;
}

/* A magnitude, and the letter of its direction. */
static void directed(const Column *column, const Block *block, double *values)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row), side = field(block, column->wire + 1, row);
        Decimal number;
        values[row] = NOTHING;
        if (empty(text))
            continue;
        if (!decimal(text, &number)) {
            block->odd[row] = true;
        } else if (!empty(side)) {
            double value = column->how == POSITION ? degrees_of(value_of(&number)) : value_of(&number);
            bool negative = only(side, column->letters[1]);
            block->odd[row] |= number.negative || !(value <= column->high)
                || !(negative || only(side, column->letters[0]));
            values[row] = negative ? 0.0 - value : value;
        }
    }
    for (int row = 0; row < block->rows && column->letter_count > 2; row++)
        block->odd[row] |= !none_or_only(field(block, column->wire + 2, row), column->letters[2]);
}

/* The number of six digits; -1 if they are none. */
static inline i64 six_digits(const u8 *at)
{
    u64 digits = digits_before(load8(at), 6);
    return no_digits(digits) ? -1 : (i64)eight_digits(digits);
}

static void times_of_day(const Column *column, const Block *block, double *values)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        values[row] = NOTHING;
        if (empty(text))
            continue;
        i64 clock = text.size < 6 ? -1 : six_digits(text.at), places = text.size > 6 ? text.size - 7 : 0;
        i64 hour = clock / 10000, minute = clock / 100 % 100, second = clock % 100;
        u64 fraction = places > 8 ? REPEATED(0xFF) : digits_before(load8(text.at + text.size - places), places);
        if (clock < 0 || hour >= 24 || minute >= 60 || second >= 60 || no_digits(fraction)
            || (text.size > 6 && text.at[6] != '.')) {
            block->odd[row] = true;
            continue;
        }
        u64 parts = (u64)second * WHOLE_POWERS[places] + eight_digits(fraction);
        values[row] = (double)((hour * 60 + minute) * 60) + (double)(i64)parts / POWERS[places];
    }
}

/* `ddmmyy`, 1980 to 2079. */
static void dates(const Column *column, const Block *block, i64 *values)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        i64 digits = text.size == 6 ? six_digits(text.at) : -1, year = digits % 100;
        i64 days = digits < 0 ? -1 : days_of(digits / 10000, digits / 100 % 100, year + (year >= 80 ? 1900 : 2000));
        values[row] = days < 0 ? INT64_MIN : days;
        block->odd[row] |= !empty(text) && days < 0;
    }
}

static void integers(const Column *column, const Block *block, i64 *values, u8 *valid)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        Decimal number = {0, -1, false};
        valid[row] = !empty(text);
        bool fine = empty(text) || (decimal(text, &number) && number.places < 0);
        values[row] = number.negative ? -(i64)number.digits : (i64)number.digits;
        block->odd[row] |= !fine || (valid[row] && !(values[row] >= column->low && values[row] <= column->high));
    }
}

static void letters(const Column *column, const Block *block, u8 *values)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        values[row] = empty(text) ? 0 : *text.at;
        block->odd[row] |=
            !empty(text) && (text.size > 1 || !memchr(column->letters, *text.at, (size_t)column->letter_count));
    }
}

static void statuses(const Column *column, const Block *block, u8 *values, u8 *valid)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        values[row] = only(text, 'A');
        valid[row] = !empty(text);
    }
}

/* Where a text is, and its size; one with `^` is not as usual. */
static void texts(const Column *column, const Block *block, i64 *begin, i64 *size)
{
    for (int row = 0; row < block->rows; row++) {
        Field text = field(block, column->wire, row);
        size[row] = empty(text) ? 0 : text.size;
        begin[row] = empty(text) ? 0 : text.at - block->text;
        block->odd[row] |= memchr(text.at, '^', (size_t)size[row]) != NULL;
    }
}

static void fill(const Column *column, const Block *block, i64 first)
{
    void *values = column->values, *valid = column->valid;
    switch (column->how) {
    case NUMBER: numbers(column, block, (double *)values + first); break;
    case SIGNED:
    case POSITION: directed(column, block, (double *)values + first); break;
    case TIME_OF_DAY: times_of_day(column, block, (double *)values + first); break;
    case DATE: dates(column, block, (i64 *)values + first); break;
    case INTEGER: integers(column, block, (i64 *)values + first, (u8 *)valid + first); break;
    case LETTER: letters(column, block, (u8 *)values + first); break;
    case STATUS: statuses(column, block, (u8 *)values + first, (u8 *)valid + first); break;
    case TEXT: texts(column, block, (i64 *)values + first, (i64 *)valid + first); break;
    }
}

/* How many bytes a row has in `values` and `valid`, and how many fields and letters are needed, by what they become. */
static const struct { i64 value, valid, wires, letters; } NEEDS[] = {
    [NUMBER] = {8, 0, 1, 0}, [SIGNED] = {8, 0, 2, 2}, [POSITION] = {8, 0, 2, 2}, [TIME_OF_DAY] = {8, 0, 1, 0},
    [DATE] = {8, 0, 1, 0}, [INTEGER] = {8, 1, 1, 0}, [LETTER] = {1, 0, 1, 0}, [STATUS] = {1, 1, 1, 0},
    [TEXT] = {8, 8, 1, 0},
};

/* A column from its tuple (how, wire, low, high, letters, values, valid), of which it takes two buffers. */
static int take_column(PyObject *tuple, Column *column, Buffers *buffers, Py_buffer *views, int wires, i64 rows)
{
    PyObject *objects[2];
    if (!PyArg_ParseTuple(tuple, "iiddy#OO", &column->how, &column->wire, &column->low, &column->high,
                          &column->letters, &column->letter_count, &objects[0], &objects[1]))
        return -1;
    if (column->how < NUMBER || column->how > TEXT || column->wire < 0
        || column->wire + NEEDS[column->how].wires > wires || column->letter_count < NEEDS[column->how].letters
        || ((column->how == NUMBER || column->how == SIGNED)
            && column->wire + NEEDS[column->how].wires + (column->letter_count > NEEDS[column->how].letters) > wires)) {
        PyErr_SetString(PyExc_ValueError, "fields: more than there are");
        return -1;
    }
    if (take_buffers(buffers, views, objects, 2, 0))
        return -1;
    if (enough(&views[0], rows, NEEDS[column->how].value, "values")
        || (NEEDS[column->how].valid && enough(&views[1], rows, NEEDS[column->how].valid, "valid"))) {
        give_buffers_back(buffers);
        return -1;
    }
    column->values = views[0].buf;
    column->valid = views[1].buf;
    return 0;
}

/* Whether the columns of all sentences were filled; not if one of these is not in the text. */
static bool fill_all(const u8 *text, i64 size, const i64 *begin, const i64 *end, i64 rows, int wires,
                     const Column *columns, i64 count, u8 *odd, i64 (*marks)[BLOCK])
{
    for (i64 first = 0; first < rows; first += BLOCK) {
        Block block = {text, marks, odd + first, rows - first < BLOCK ? (int)(rows - first) : BLOCK};
        for (int row = 0; row < block.rows; row++) {
            i64 at = begin[first + row], last = end[first + row] - 3; /* the check sum's star */
            if (at < PADDING || last < at || last + 3 > size - PADDING)
                return false;
            split(text, at, last, wires, &marks[0][row]);
        }
        for (i64 column = 0; column < count; column++)
            fill(&columns[column], &block, first);
    }
    return true;
}

/* (text, begin, end, wires, fields, odd) -> None: the columns of these sentences; `fields` are tuples (how, wire, low,
   high, letters, values, valid), see NEEDS. */
PyObject *sentence_columns(PyObject *module, PyObject *arguments)
{
    PyObject *objects[4], *fields, *result = NULL;
    Py_buffer views[4], column_views[MOST_FIELDS][2];
    Buffers buffers, column_buffers[MOST_FIELDS];
    Column columns[MOST_FIELDS];
    int wires;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OOOiO!O", &objects[0], &objects[1], &objects[2], &wires, &PyTuple_Type, &fields,
                          &objects[3])
        || take_buffers(&buffers, views, objects, 4, 3))
        return NULL;
    i64 rows = views[1].len / 8, count = PyTuple_Size(fields), taken = 0;
    i64 (*marks)[BLOCK] = NULL;
    if (enough(&views[0], 2 * PADDING, 1, "text") || enough(&views[2], rows, 8, "end")
        || enough(&views[3], rows, 1, "odd"))
        goto end;
    if (wires < 0 || wires > MOST_WIRES || count > MOST_FIELDS) {
        PyErr_SetString(PyExc_ValueError, "fields: too many");
        goto end;
    }
    for (; taken < count; taken++)
        if (take_column(PyTuple_GetItem(fields, taken), &columns[taken], &column_buffers[taken], column_views[taken],
                        wires, rows))
            goto end;
    marks = malloc(sizeof(*marks) * (size_t)(wires + 1));
    if (!marks) {
        PyErr_NoMemory();
        goto end;
    }
    bool there;
    Py_BEGIN_ALLOW_THREADS
    there = fill_all(views[0].buf, views[0].len, views[1].buf, views[2].buf, rows, wires, columns, count, views[3].buf,
                     marks);
    Py_END_ALLOW_THREADS
    if (there)
        result = Py_NewRef(Py_None);
    else
        PyErr_SetString(PyExc_ValueError, "begin or end: a sentence that is not there");
end:
    free(marks);
    while (taken)
        give_buffers_back(&column_buffers[--taken]);
    give_buffers_back(&buffers);
    return result;
}
