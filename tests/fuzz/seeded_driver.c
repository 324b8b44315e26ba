/* SPDX-License-Identifier: MIT
 *
 * Runs a fuzz target without libFuzzer, on seeded mutations, under limits of memory and time: a
 * wild allocation fails, a hang is told, and the case that broke something is named.
 *
 *   PROGRAM                  all rounds
 *   PROGRAM --round N        one of them again
 *   PROGRAM --print N        the input of a round, for a look at it
 *   PROGRAM --seeds FOLDER   writes the seeds there, for libFuzzer's corpus
 *   PROGRAM FILE             runs one input
 */
#include <limits.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/rng.h"
#include "target.h"

enum { LONGEST = 1 << 17, CASE_SECONDS = 20 };

#if defined(__SANITIZE_ADDRESS__)
#define ROOM 0 /* the address sanitiser reserves terabytes: it has a limit of its own */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "max_allocation_size_mb=2048:allocator_may_return_null=1";
}
#else
#define ROOM (UINT64_C(3) << 30)
#endif

struct dice {
    uint64_t round;
    uint32_t draw;
};

static size_t roll(struct dice *dice, size_t n)
{
    double u[4];
    rmap_rng(2031, dice->round, dice->draw++, 0, u);
    return (size_t)(u[0] * (double)n);
}

/* Sizes and numbers at the edges that programs stumble over. */
static const uint64_t edge[] = {0,
                                1,
                                2,
                                0x7f,
                                0x80,
                                0xff,
                                0x7fff,
                                0xffff,
                                0x10000,
                                0x7fffffff,
                                0x80000000,
                                0xffffffff,
                                0x100000000,
                                0x7fffffffffffffff,
                                0x8000000000000000,
                                0xffffffffffffffff};

static size_t cut(uint8_t *at, size_t n, size_t from, size_t len)
{
    memmove(at + from, at + from + len, n - from - len);
    return n - len;
}

static size_t put_in(uint8_t *at, size_t n, size_t to, const uint8_t *bytes, size_t len)
{
    if (n + len > LONGEST)
        return n;
    memmove(at + to + len, at + to, n - to);
    memcpy(at + to, bytes, len);
    return n + len;
}

static size_t mutate(struct dice *dice, uint8_t *at, size_t n)
{
    uint8_t piece[64];
    uint64_t value = edge[roll(dice, sizeof edge / sizeof *edge)] + roll(dice, 3) - 1;
    size_t place = roll(dice, n), len = 1 + roll(dice, sizeof piece), width = 1u << roll(dice, 4);
    if (len > n - place)
        len = n - place;
    if (width > n - place)
        width = n - place;
    switch (roll(dice, 7)) {
    case 0:
        at[place] ^= (uint8_t)(1u << roll(dice, 8));
        return n;
    case 1:
        at[place] = (uint8_t)roll(dice, 256);
        return n;
    case 2:
        memcpy(at + place, &value, width);
        return n;
    case 3:
        return roll(dice, 3) ? n : place; /* cut off */
    case 4:
        return cut(at, n, place, len);
    case 5:
        memcpy(piece, at + place, len);
        return put_in(at, n, roll(dice, n), piece, len);
    default:
        memcpy(piece, at + place, len);
        place = roll(dice, n - len + 1);
        memcpy(at + place, piece, len);
        return n;
    }
}

/* Input of a round: a seed, two of them joined now and then, with some changes. */
static size_t make(uint64_t round, unsigned n_seed, uint8_t *to)
{
    static uint8_t other[LONGEST];
    struct dice dice = {round, 0};
    size_t n = rmap_fuzz_seed((unsigned)roll(&dice, n_seed), to, LONGEST);
    if (roll(&dice, 8) == 0) {
        size_t m = rmap_fuzz_seed((unsigned)roll(&dice, n_seed), other, LONGEST);
        size_t at = roll(&dice, n + 1), from = roll(&dice, m + 1);
        n = at + (m - from < LONGEST - at ? m - from : LONGEST - at);
        memcpy(to + at, other + from, n - at);
    }
    for (size_t k = 1 + roll(&dice, 6); k > 0 && n > 0; k--)
        n = mutate(&dice, to, n);
    return n;
}

static char now[96]; /* the message of a signal */

static void told(int number)
{
    ssize_t n = write(2, now, strlen(now));
    (void)n;
    (void)signal(number, SIG_DFL);
    (void)raise(number == SIGALRM ? SIGKILL : number);
}

static void run_one(const uint8_t *data, size_t nbytes)
{
    /* A block of just these bytes, so that checkers of memory see reads past its end. */
    uint8_t *exact = malloc(nbytes ? nbytes : 1);
    rmap_fuzz_demand(exact != NULL, "memory for an input");
    if (nbytes)
        memcpy(exact, data, nbytes);
    (void)alarm(CASE_SECONDS);
    (void)LLVMFuzzerTestOneInput(exact, nbytes);
    (void)alarm(0);
    free(exact);
}

static int write_seeds(const char *folder, unsigned n_seed)
{
    static uint8_t data[LONGEST];
    for (unsigned k = 0; k < n_seed; k++) {
        char path[512];
        size_t n = rmap_fuzz_seed(k, data, sizeof data);
        (void)snprintf(path, sizeof path, "%s/seed-%02u", folder, k);
        FILE *out = fopen(path, "wb");
        if (!out || fwrite(data, 1, n, out) != n || fclose(out) != 0) {
            perror(path);
            return 1;
        }
    }
    return 0;
}

static int run_file(const char *path)
{
    static uint8_t data[LONGEST];
    FILE *in = fopen(path, "rb");
    if (!in) {
        perror(path);
        return 1;
    }
    size_t n = fread(data, 1, sizeof data, in);
    (void)fclose(in);
    run_one(data, n);
    return 0;
}

int main(int argc, char **argv)
{
    static uint8_t data[LONGEST];
    unsigned n_seed = 0;
    const struct rlimit room = {ROOM, ROOM}, seconds = {600, 600};
    while (rmap_fuzz_seed(n_seed, data, sizeof data) > 0)
        n_seed++;
    rmap_fuzz_demand(n_seed > 0, "no seeds");
    if (argc == 3 && strcmp(argv[1], "--seeds") == 0)
        return write_seeds(argv[2], n_seed);
    if (argc == 3 && strcmp(argv[1], "--print") == 0) {
        size_t n = make(strtoull(argv[2], NULL, 10), n_seed, data);
        return fwrite(data, 1, n, stdout) != n;
    }
    if (argc == 2)
        return run_file(argv[1]);
    /* Memory given back to the system and had again costs more than all else here. */
    (void)mallopt(M_MMAP_THRESHOLD, 1 << 30);
    (void)mallopt(M_TRIM_THRESHOLD, INT_MAX);
    if (ROOM > 0)
        (void)setrlimit(RLIMIT_AS, &room);
    (void)setrlimit(RLIMIT_CPU, &seconds);
    for (const int *s = (const int[]){SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGALRM, 0}; *s; s++)
        (void)signal(*s, told);
    uint64_t first = 0, last = rmap_fuzz_rounds;
    unsigned every = 1;
    if (argc == 3 && strcmp(argv[1], "--round") == 0) {
        first = strtoull(argv[2], NULL, 10);
        last = first + 1;
    } else if (argc == 3 && strcmp(argv[1], "--every") == 0) {
        every = (unsigned)strtoul(argv[2], NULL, 10);
    }
    for (unsigned k = 0; k < n_seed && first == 0 && every > 0; k += every) {
        (void)snprintf(now, sizeof now, "seed %u crashed or hung\n", k);
        run_one(data, rmap_fuzz_seed(k, data, sizeof data));
    }
    for (uint64_t round = first; round < last; round++) {
        (void)snprintf(now, sizeof now, "crashed or hung; again: --round %llu\n",
                       (unsigned long long)round);
        run_one(data, make(round, n_seed, data));
    }
    printf("every %u of %u seeds, %llu mutations: none crashed, hung or broke a promise\n", every,
           n_seed, (unsigned long long)(last - first));
    return 0;
}
