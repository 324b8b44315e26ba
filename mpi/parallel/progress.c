/* SPDX-License-Identifier: MIT
 *
 * How far long work has come: one line kept up to date on a terminal, a plain line now and then
 * elsewhere, nothing with --quiet.
 */
#include "mpi/parallel/progress.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "mpi/parallel/at_hand.h"

/* Between two lines of a log: a tenth of the time so far. */
enum { LOG_FIRST_S = 10, LOG_MOST_S = 900 };

static const double told_s = 0.1; /* between two, of who asked */

/* Goes past standard error's guard (terminal.h), which shows it instead. */
#define CLEAR_LINE "\r\033[K"

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
                               : LOG_FIRST_S,
        .terminal = terminal,
        .at_hand = context->rank == 0 ? context->at_hand : NULL,
        .told = now,
    };
}

static void print_clock(char *text, size_t nbytes)
{
    const time_t now = time(NULL);
    struct tm local;
    if (!localtime_r(&now, &local) || strftime(text, nbytes, "%F %T ", &local) == 0)
        text[0] = 0;
}

/* m:ss, or h:mm:ss. */
static void print_duration(double seconds, char *text, size_t nbytes)
{
    const unsigned long s = (unsigned long)(seconds + 0.5), h = s / 3600;
    if (h > 0)
        (void)snprintf(text, nbytes, "%lu:%02lu:%02lu", h, s / 60 % 60, s % 60);
    else
        (void)snprintf(text, nbytes, "%lu:%02lu", s / 60, s % 60);
}

/* Columns of the terminal but the last, in which some wrap. */
static int columns(void)
{
    struct winsize size = {0};
    const bool told = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return told ? size.ws_col - 1 : INT_MAX;
}

static void print_line(const struct rmap_progress *progress, uint64_t done, double rate)
{
    char now[RMAP_GROUPED_LEN], total[RMAP_GROUPED_LEN], speed[RMAP_GROUPED_LEN];
    char clock[32] = CLEAR_LINE, left[32];
    print_duration(rate > 0 ? (double)(progress->total - done) / rate : 0.0, left, sizeof left);
    if (!progress->terminal)
        print_clock(clock, sizeof clock);
    char line[256];
    (void)snprintf(line, sizeof line, "%s of %s %s (%.0f %%), %s/s, %s left",
                   rmap_grouped(done, now), rmap_grouped(progress->total, total), progress->what,
                   100.0 * (double)done / (double)progress->total,
                   rmap_grouped((uint64_t)rate, speed), left);
    dprintf(STDERR_FILENO, "%s%.*s%s", clock, progress->terminal ? columns() : INT_MAX, line,
            progress->terminal ? "" : "\n");
}

void rmap_progress_show(struct rmap_progress *progress, uint64_t done)
{
    if (progress->total == 0 || (progress->interval <= 0.0 && !progress->at_hand))
        return;
    const double now = rmap_clock_seconds(), passed = now - progress->begun;
    if (progress->at_hand && progress->at_hand->progressed && now - progress->told > told_s) {
        progress->told = now;
        progress->at_hand->progressed(progress->at_hand->context,
                                      (double)done / (double)progress->total);
    }
    if (progress->interval <= 0.0 || now - progress->last < progress->interval)
        return;
    progress->last = now;
    progress->shown = true;
    if (!progress->terminal && passed > 10.0 * LOG_FIRST_S)
        progress->interval = passed < 10.0 * LOG_MOST_S ? passed / 10.0 : LOG_MOST_S;
    if (done > progress->total)
        done = progress->total;
    print_line(progress, done, (double)done / passed);
}

void rmap_progress_fini(struct rmap_progress *progress)
{
    if (progress->shown && progress->terminal)
        (void)write(STDERR_FILENO, CLEAR_LINE, strlen(CLEAR_LINE));
    progress->shown = false;
}
