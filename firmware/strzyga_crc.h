/* strzyga-crc: the rover's UART frames with a check sum.
 *
 *     '#' (0x23)   id   data   CRC high byte   CRC low byte
 *
 * The id fixes the number of data bytes. The CRC is CRC-16/CCITT-FALSE (polynomial 0x1021, initially 0xFFFF,
 * nothing reflected or inverted) over id and data.
 *
 * C99, no allocation, no library. Not reentrant: give each UART its own decoder and call it from one context.
 */
#ifndef STRZYGA_CRC_H
#define STRZYGA_CRC_H

#include <stddef.h>
#include <stdint.h>

/* Most data bytes of a frame (of the built-in ones, 111 has most); at most 254. */
#ifndef STRZYGA_MOST_DATA
#define STRZYGA_MOST_DATA 12
#endif

/* Bytes around the data: '#', id, CRC. */
#define STRZYGA_OVERHEAD 4

/* Entry of a length table for an id that is not a frame. */
#define STRZYGA_UNKNOWN 0xFF

/* Takes one frame; `data` is valid until it returns. It must not feed the decoder that calls it. */
typedef void (*strzyga_sink)(void *context, uint8_t id, const uint8_t *data, uint8_t length);

typedef struct {
    const uint8_t *lengths; /* of 256 ids: data bytes, or STRZYGA_UNKNOWN */
    strzyga_sink sink;
    void *context;
    size_t count;                                      /* bytes of `held` in use */
    uint8_t held[STRZYGA_MOST_DATA + STRZYGA_OVERHEAD]; /* a frame so far */
    uint8_t adrift;                                    /* bytes were skipped since the last frame */
    uint32_t frames;
    uint32_t skipped;        /* bytes that found no place in a frame */
    uint32_t rejected;       /* a '#' with a known id that was not a frame */
    uint32_t resynchronised; /* frames found again behind skipped bytes */
} strzyga_decoder;

/* Writes one frame to `out`, which holds `length` + STRZYGA_OVERHEAD bytes; returns how many were written. */
size_t strzyga_write(uint8_t *out, uint8_t id, const uint8_t *data, uint8_t length);

/* List in `lengths` the ids of the decoder's own direction only. The table must outlive the decoder. */
void strzyga_start(strzyga_decoder *decoder, const uint8_t *lengths, strzyga_sink sink, void *context);

/* Takes one byte from the UART; hands every frame that it completes to the sink. */
void strzyga_receive(strzyga_decoder *decoder, uint8_t byte);

/* The line has been silent (some 5 ms): a frame begun will not be completed any more. */
void strzyga_silence(strzyga_decoder *decoder);

#endif
