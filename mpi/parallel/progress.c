/* SPDX-License-Identifier: MIT
 *
 * How far long work has come: one line kept up to date on a terminal, a plain line now and then
 * elsewhere, nothing with --quiet.
 */
#include "mpi/parallel/progress.h"

#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Goes past standard error's guard (terminal.h), which shows it instead. */
#define CLEAR_LINE "\r\033[K"

double rmap_clock_seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void rmap_progress_init(struct rmap_progress *progress, const struct rmap_context *context,
                        const char *what, uint64_t total)
{
    double now = rmap_clock_seconds();
    bool terminal = isatty(STDERR_FILENO) == 1;
    bool silent = context->quiet || context->rank != 0;
    *progress = (struct rmap_progress){
        .what = what,
        .total = total,
        .begun = now,
        .last = now,
        .interval = silent     ? 0.0
                    : terminal ? 0.25
                               : 10.0,
        .terminal = terminal,
    };
}

static void print_line(const struct rmap_progress *progress, uint64_t done, double rate)
{
    char now[RMAP_GROUPED_LEN], total[RMAP_GROUPED_LEN], speed[RMAP_GROUPED_LEN];
    double left = rate > 0 ? (double)(progress->total - done) / rate : 0.0;
    unsigned long whole = (unsigned long)(left + 0.5);
    dprintf(STDERR_FILENO, "%s%s of %s %s (%.0f %%), %s/s, %lu:%02lu left%s",
            progress->terminal ? CLEAR_LINE : "", rmap_grouped(done, now),
            rmap_grouped(progress->total, total), progress->what,
            100.0 * (double)done / (double)progress->total, rmap_grouped((uint64_t)rate, speed),
            whole / 60, whole % 60, progress->terminal ? "" : "\n");
}

void rmap_progress_show(struct rmap_progress *progress, uint64_t done)
{
    if (progress->interval <= 0.0 || progress->total == 0)
        return;
    double now = rmap_clock_seconds();
    if (now - progress->last < progress->interval)
        return;
    progress->last = now;
    progress->shown = true;
    if (done > progress->total)
        done = progress->total;
    print_line(progress, done, (double)done / (now - progress->begun));
}

void rmap_progress_fini(struct rmap_progress *progress)
{
    if (progress->shown && progress->terminal)
        (void)write(STDERR_FILENO, CLEAR_LINE, strlen(CLEAR_LINE));
    progress->shown = false;
}
