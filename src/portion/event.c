/* SPDX-License-Identifier: MIT
 *
 * What can happen at the end of a segment.
 */
#include "portion/event.h"

#include <stddef.h>
#include <string.h>

#include "base/count.h"

static const struct {
    uint32_t bit;
    char letter;
    const char *word;
} event_row[] = {
#define ROW(symbol, bit, letter, word, meaning) {RMAP_EVENT_##symbol, letter, word},
    RMAP_EVENT_TABLE(ROW)
#undef ROW
};

static const struct {
    const char *word;
    uint32_t mask;
} union_row[] = {
#define ROW(word, mask) {word, mask},
    RMAP_EVENT_UNION_TABLE(ROW)
#undef ROW
};

const char *rmap_event_word(uint32_t bit)
{
    for (size_t i = 0; i < RMAP_COUNT(event_row); i++)
        if (event_row[i].bit == bit)
            return event_row[i].word;
    return NULL;
}

uint32_t rmap_event_mask(const char *word)
{
    for (size_t i = 0; i < RMAP_COUNT(event_row); i++)
        if (strcmp(event_row[i].word, word) == 0)
            return event_row[i].bit;
    for (size_t i = 0; i < RMAP_COUNT(union_row); i++)
        if (strcmp(union_row[i].word, word) == 0)
            return union_row[i].mask;
    return 0;
}

char rmap_event_letter(uint32_t events)
{
    for (const char *letter = "EKOFSIRTDdAX"; *letter; letter++)
        for (size_t i = 0; i < RMAP_COUNT(event_row); i++)
            if (event_row[i].letter == *letter && (events & event_row[i].bit))
                return *letter;
    return 0;
}

const char *rmap_event_bits(void)
{
    static const char bits[] =
#define BIT(symbol, bit, letter, word, meaning) ", " word " = 2^" #bit
        RMAP_EVENT_TABLE(BIT);
#undef BIT
    return bits + 2;
}

const char *rmap_stop_word(int stop)
{
    static const char *const word[] = {
#define ROW(symbol, value, word) [value] = word,
        RMAP_STOP_TABLE(ROW)
#undef ROW
    };
    return stop >= 0 && (size_t)stop < RMAP_COUNT(word) ? word[stop] : NULL;
}
