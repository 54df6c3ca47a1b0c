/* Rows by their codes, block by block. */
#ifndef TIMONEL_SORTING_H
#define TIMONEL_SORTING_H

#include "kernels.h"

/* Rows that are looked at together: what they are sorted into stays in the processor's cache. What is done with each
   row is the same for all of them, as a processor guesses wrongly which of them are wanted. */
enum { BLOCK = 1 << 13, CODES_MAX = 1 << 16 };

/* The codes that are wanted: their `count`, the code of each, and the number of each code, `count` for all others;
   where in a block's order those of each kind end. */
typedef struct {
    u16 *number, *code;
    u32 *ends, count;
} Kinds;

/* Room for the codes; 1 without it. */
static inline int take_kinds(Kinds *chosen)
{
    *chosen = (Kinds){malloc(2 * CODES_MAX), malloc(2 * CODES_MAX), NULL, 0};
    return !chosen->number || !chosen->code;
}

static inline void give_kinds_back(Kinds *chosen)
{
    free(chosen->number);
    free(chosen->code);
    free(chosen->ends);
}

/* Numbers the codes, of which there must not be all; 1 without room. */
static inline int number_kinds(Kinds *chosen)
{
    for (u32 code = 0; code < CODES_MAX; code++)
        chosen->number[code] = (u16)chosen->count;
    for (u32 kind = 0; kind < chosen->count; kind++)
        chosen->number[chosen->code[kind]] = (u16)kind;
    chosen->ends = malloc(4 * (size_t)(chosen->count + 2));
    return !chosen->ends;
}

/* The rows of a block in the order of their kinds. */
static inline void sort_block(const u16 *codes, i64 count, const Kinds *chosen, u16 *order)
{
    u16 kinds[BLOCK];
    u32 *ends = chosen->ends;
    memset(ends, 0, 4 * (size_t)(chosen->count + 2));
    for (i64 row = 0; row < count; row++) {
        kinds[row] = chosen->number[codes[row]];
        ends[kinds[row] + 1]++; /* one further on: each begins where the one before it ends */
    }
    for (u32 kind = 1; kind <= chosen->count; kind++)
        ends[kind] += ends[kind - 1];
    for (i64 row = 0; row < count; row++)
        order[ends[kinds[row]]++] = (u16)row;
}

#endif
