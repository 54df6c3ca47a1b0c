/* What the reference decoder makes of a stream: framing of its own on standard input and output, for the test.
 *
 * in:   256 bytes, the length table; then portions: size (2 bytes, high first), bytes. A portion of no bytes is silence.
 * out:  every frame as the encoder writes it, behind its size in one byte; a zero; frames, skipped, rejected,
 *       resynchronised, waiting (4 bytes each, high first).
 */
#include "strzyga_crc.h"

#include <stdio.h>

static void again(void *context, uint8_t id, const uint8_t *data, uint8_t length)
{
    uint8_t out[STRZYGA_MOST_DATA + STRZYGA_OVERHEAD];
    size_t size = strzyga_write(out, id, data, length);
    (void)context;
    putchar((int)size);
    fwrite(out, 1, size, stdout);
}

static void put(uint32_t number)
{
    int shift;
    for (shift = 24; shift >= 0; shift -= 8)
        putchar((int)(number >> shift & 0xFF));
}

int main(void)
{
    static uint8_t lengths[256];
    strzyga_decoder decoder;
    int high;
    if (fread(lengths, 1, sizeof lengths, stdin) != sizeof lengths)
        return 1;
    strzyga_start(&decoder, lengths, again, NULL);
    while ((high = getchar()) != EOF) {
        int size = high << 8 | getchar();
        if (size == 0)
            strzyga_silence(&decoder);
        while (size-- > 0)
            strzyga_receive(&decoder, (uint8_t)getchar());
    }
    putchar(0);
    put(decoder.frames);
    put(decoder.skipped);
    put(decoder.rejected);
    put(decoder.resynchronised);
    put((uint32_t)decoder.count);
    return 0;
}
