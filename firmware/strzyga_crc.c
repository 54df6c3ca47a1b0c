#include "strzyga_crc.h"

#include <string.h>

#define START 0x23

/* CRC-16/CCITT-FALSE, a byte at a time without a table. */
static uint16_t crc16(const uint8_t *bytes, size_t count)
{
    uint16_t crc = 0xFFFF;
    while (count--) {
        crc = (uint16_t)((crc >> 8) | (crc << 8));
        crc = (uint16_t)(crc ^ *bytes++);
        crc = (uint16_t)(crc ^ ((crc & 0xFF) >> 4));
        crc = (uint16_t)(crc ^ ((unsigned)crc << 12));
        crc = (uint16_t)(crc ^ ((crc & 0xFF) << 5));
    }
    return crc;
}

size_t strzyga_write(uint8_t *out, uint8_t id, const uint8_t *data, uint8_t length)
{
    uint16_t crc;
    out[0] = START;
    out[1] = id;
    if (length > 0)
        memcpy(out + 2, data, length);
    crc = crc16(out + 1, (size_t)length + 1);
    out[length + 2] = (uint8_t)(crc >> 8);
    out[length + 3] = (uint8_t)(crc & 0xFF);
    return (size_t)length + STRZYGA_OVERHEAD;
}

void strzyga_start(strzyga_decoder *decoder, const uint8_t *lengths, strzyga_sink sink, void *context)
{
    memset(decoder, 0, sizeof *decoder);
    decoder->lengths = lengths;
    decoder->sink = sink;
    decoder->context = context;
}

static void discard(strzyga_decoder *decoder, size_t count)
{
    decoder->count -= count;
    memmove(decoder->held, decoder->held + count, decoder->count);
}

static void skip(strzyga_decoder *decoder, size_t count)
{
    decoder->skipped += (uint32_t)count;
    decoder->adrift = 1;
    discard(decoder, count);
}

static void find_start(strzyga_decoder *decoder)
{
    size_t count = 0;
    while (count < decoder->count && decoder->held[count] != START)
        count++;
    if (count > 0)
        skip(decoder, count);
}

/* The '#' at the beginning begins no frame: the search goes on behind it. */
static void reject(strzyga_decoder *decoder)
{
    if (decoder->count > 1 && decoder->lengths[decoder->held[1]] <= STRZYGA_MOST_DATA)
        decoder->rejected++;
    skip(decoder, 1);
}

static void emit(strzyga_decoder *decoder, uint8_t length)
{
    decoder->frames++;
    decoder->resynchronised += decoder->adrift;
    decoder->adrift = 0;
    decoder->sink(decoder->context, decoder->held[1], decoder->held + 2, length);
    discard(decoder, (size_t)length + STRZYGA_OVERHEAD);
}

/* Decides about the first '#' that is held; 0 if that takes more bytes. */
static int decide(strzyga_decoder *decoder)
{
    uint8_t length;
    find_start(decoder);
    if (decoder->count < 2)
        return 0;
    length = decoder->lengths[decoder->held[1]];
    if (length > STRZYGA_MOST_DATA) {
        reject(decoder);
        return 1;
    }
    if (decoder->count < (size_t)length + STRZYGA_OVERHEAD)
        return 0;
    if (crc16(decoder->held + 1, (size_t)length + 3) == 0) /* over id, data and CRC together */
        emit(decoder, length);
    else
        reject(decoder);
    return 1;
}

void strzyga_receive(strzyga_decoder *decoder, uint8_t byte)
{
    decoder->held[decoder->count++] = byte;
    while (decide(decoder)) {
    }
}

void strzyga_silence(strzyga_decoder *decoder)
{
    while (decoder->count > 0) {
        reject(decoder);
        while (decide(decoder)) {
        }
    }
}
