/* SPDX-License-Identifier: MIT
 *
 * What verifying a map finds wrong: the place, and the rays that it costs.
 */
#include "io/file/findings.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

void rmap_findings_fini(struct rmap_findings *findings)
{
    rmap_free(findings->row);
    *findings = (struct rmap_findings){0};
}

/* Messages begin with the path of the file, which the finding names already. */
static void cut_path(char *text, const char *file)
{
    const char *at = *file ? strstr(text, file) : NULL;
    if (at && strncmp(at + strlen(file), ": ", 2) == 0) {
        at += strlen(file) + 2;
        memmove(text, at, strlen(at) + 1);
    }
}

void rmap_finding_set(struct rmap_finding *finding, const char *file, const char *dataset,
                      const char *format, ...)
{
    va_list arguments;
    memset(finding, 0, sizeof *finding); /* padding too: findings travel as bytes */
    finding->chunk = -1;
    (void)snprintf(finding->file, sizeof finding->file, "%s", file);
    (void)snprintf(finding->dataset, sizeof finding->dataset, "%s", dataset);
    va_start(arguments, format);
    (void)vsnprintf(finding->text, sizeof finding->text, format, arguments);
    va_end(arguments);
    cut_path(finding->text, finding->file);
}

void rmap_finding_add_rays(struct rmap_finding *finding, uint64_t first, uint64_t n)
{
    if (n == 0)
        return;
    finding->n_ray += n;
    uint64_t *last = finding->n_range > 0 ? finding->range[finding->n_range - 1] : NULL;
    if (last && (last[1] + 1 == first || finding->n_range == RMAP_FINDING_RANGES)) {
        last[1] = first + n - 1;
        return;
    }
    finding->range[finding->n_range][0] = first;
    finding->range[finding->n_range++][1] = first + n - 1;
}

enum rmap_status rmap_findings_append(struct rmap_findings *findings,
                                      const struct rmap_finding *row, size_t n,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(findings->row, findings->cap, findings->n + n, err);
    if (st != RMAP_OK || n == 0)
        return st;
    memcpy(findings->row + findings->n, row, n * sizeof *row);
    findings->n += n;
    return RMAP_OK;
}

enum rmap_status rmap_findings_add(struct rmap_findings *findings,
                                   const struct rmap_finding *finding, struct rmap_error *err)
{
    return rmap_findings_append(findings, finding, 1, err);
}

static int in_order(const void *a, const void *b)
{
    const struct rmap_finding *x = a, *y = b;
    int order = strchr(x->file, '/') ? 1 : 0;
    order -= strchr(y->file, '/') ? 1 : 0;
    if (order == 0)
        order = strcmp(x->file, y->file);
    if (order == 0)
        order = strcmp(x->dataset, y->dataset);
    if (order == 0)
        order = (x->chunk > y->chunk) - (x->chunk < y->chunk);
    if (order == 0)
        order = (x->first_row > y->first_row) - (x->first_row < y->first_row);
    if (order == 0)
        order = (x->range[0][0] > y->range[0][0]) - (x->range[0][0] < y->range[0][0]);
    return order ? order : strcmp(x->text, y->text);
}

void rmap_findings_sort(struct rmap_findings *findings)
{
    size_t kept = 0;
    if (findings->n == 0)
        return;
    qsort(findings->row, findings->n, sizeof *findings->row, in_order);
    for (size_t i = 1; i < findings->n; i++)
        if (in_order(&findings->row[kept], &findings->row[i]) != 0)
            findings->row[++kept] = findings->row[i];
    findings->n = kept + 1;
}

enum rmap_status rmap_findings_note(struct rmap_findings *findings, const char *file,
                                    const char *text, struct rmap_error *err)
{
    struct rmap_finding finding;
    rmap_finding_set(&finding, file, "", "%s", text);
    return rmap_findings_add(findings, &finding, err);
}

enum rmap_status rmap_findings_take(struct rmap_findings *findings, const char *file,
                                    const char *dataset, enum rmap_status st,
                                    const struct rmap_error *why, struct rmap_error *err)
{
    struct rmap_finding finding;
    if (st == RMAP_OK)
        return RMAP_OK;
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why->text);
    rmap_finding_set(&finding, file, dataset, "%s", why->text);
    return rmap_findings_add(findings, &finding, err);
}
