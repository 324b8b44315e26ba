/* SPDX-License-Identifier: MIT
 *
 * The calls that ask for memory, and a book of what they gave: with FAULTS_LEAKS, what the program
 * itself asked for and nobody gave back is counted when the process ends.
 */
#include <execinfo.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fault_plan.h"

enum { SLOTS = 1 << 18, FRAMES = 8, SHOWN = 5 };

struct origin {
    int n_frame;
    void *frame[FRAMES];
};

/* Blocks stand together, since all that is given back is looked for among them. */
static struct {
    uintptr_t *block;      /* [SLOTS], 0: never used; 1: free again. NULL: no book is kept */
    struct origin *origin; /* [SLOTS] */
    int out;
    size_t n_live;
    int overflown;
    atomic_flag lock;
} book = {.lock = ATOMIC_FLAG_INIT, .out = -1};

__attribute__((constructor)) static void open_book(void)
{
    void *frame[1];
    book.out = fault_open_output("FAULTS_LEAKS");
    if (book.out < 0)
        return;
    (void)backtrace(frame, 1); /* it loads a library, now and not in the middle of something */
    void *room = mmap(NULL, SLOTS * (sizeof *book.block + sizeof *book.origin),
                      PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED)
        return;
    book.block = room;
    book.origin = (struct origin *)(book.block + SLOTS);
}

static size_t slot_of(uintptr_t block)
{
    return (size_t)((block >> 4) * UINT64_C(0x9e3779b97f4a7c15) >> 40) % SLOTS;
}

static void lock_book(void)
{
    while (atomic_flag_test_and_set_explicit(&book.lock, memory_order_acquire))
        ;
}

static void unlock_book(void)
{
    atomic_flag_clear_explicit(&book.lock, memory_order_release);
}

static void enter(void *given)
{
    uintptr_t block = (uintptr_t)given;
    struct origin as;
    if (!book.block || !given)
        return;
    as.n_frame = backtrace(as.frame, FRAMES);
    lock_book();
    if (book.n_live >= SLOTS / 2) {
        book.overflown = 1;
    } else {
        size_t at = slot_of(block);
        while (book.block[at] > 1)
            at = (at + 1) % SLOTS;
        book.block[at] = block;
        book.origin[at] = as;
        book.n_live++;
    }
    unlock_book();
}

static void strike_out(void *given)
{
    uintptr_t block = (uintptr_t)given;
    if (!book.block || !given)
        return;
    lock_book();
    for (size_t at = slot_of(block), n = 0; book.block[at] && n < SLOTS; n++) {
        if (book.block[at] == block) {
            book.block[at] = 1;
            book.n_live--;
            break;
        }
        at = (at + 1) % SLOTS;
    }
    unlock_book();
}

__attribute__((destructor)) static void close_book(void)
{
    if (!book.block)
        return;
    uintptr_t *block = book.block;
    book.block = NULL;
    (void)dprintf(book.out, "%zu%s\n", book.n_live, book.overflown ? " at least" : "");
    for (size_t at = 0, n = 0; n < SHOWN && n < book.n_live; at++) {
        if (block[at] <= 1)
            continue;
        backtrace_symbols_fd(book.origin[at].frame, book.origin[at].n_frame, book.out);
        (void)dprintf(book.out, "\n");
        n++;
    }
}

/* dlsym itself asks for memory, so glibc's own names are used. Only what the program asks for
 * counts; libraries that cannot bear a failure are their own makers' concern. */
void *__libc_malloc(size_t nbytes);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *block, size_t nbytes);
void __libc_free(void *block);

static bool fails(const char *call)
{
    return fault_decide(call, "") != FAULT_NONE;
}

void *malloc(size_t nbytes)
{
    if (!fault_in_program(__builtin_return_address(0)))
        return __libc_malloc(nbytes);
    void *block = fails("memory:malloc") ? NULL : __libc_malloc(nbytes);
    enter(block);
    return block;
}

void *calloc(size_t n, size_t size)
{
    if (!fault_in_program(__builtin_return_address(0)))
        return __libc_calloc(n, size);
    void *block = fails("memory:calloc") ? NULL : __libc_calloc(n, size);
    enter(block);
    return block;
}

void *realloc(void *block, size_t nbytes)
{
    if (!fault_in_program(__builtin_return_address(0)))
        return __libc_realloc(block, nbytes);
    if (fails("memory:realloc"))
        return NULL;
    strike_out(block);
    void *grown = __libc_realloc(block, nbytes);
    enter(grown ? grown : block);
    return grown;
}

void free(void *block)
{
    strike_out(block);
    __libc_free(block);
}
