/* SPDX-License-Identifier: MIT
 *
 * What `raymap compare` is asked for.
 */
#include "mpi/answer/compare_request.h"

#include <stdio.h>
#include <string.h>

#include "analysis/compare/compare_field.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "mpi/answer/compare_write.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/output.h"

/* Index of a word in a list that ends with NULL. RMAP_USAGE with the nearest one. */
static enum rmap_status find_word(const char *text, const char *option, const char *const *word,
                                  size_t *found, struct rmap_error *err)
{
    size_t n = 0;
    for (; word[n]; n++)
        if (strcmp(word[n], text) == 0) {
            *found = n;
            return RMAP_OK;
        }
    const char *nearest = rmap_nearest_word(text, word, n);
    if (nearest)
        return rmap_error_set(err, RMAP_USAGE, "--%s '%s' is none (did you mean '%s'?)", option,
                              text, nearest);
    char known[160] = "";
    size_t len = 0;
    for (size_t k = 0; k < n && len < sizeof known; k++)
        len += (size_t)snprintf(known + len, sizeof known - len, "%s%s", k ? ", " : "", word[k]);
    return rmap_error_set(err, RMAP_USAGE, "--%s '%s' is none: say one of %s", option, text, known);
}

static enum rmap_status read_kinds(const struct rmap_arguments *given, unsigned *kinds,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char **list = NULL;
    size_t n = 0, kind = 0;
    *kinds = 0;
    RMAP_TRY(rmap_argument_list(given, "test", &list, &n, err));
    for (size_t i = 0; i < n; i++) {
        RMAP_TRY(find_word(list[i], "test", rmap_compare_word, &kind, err));
        *kinds |= 1u << kind;
    }
    if (n == 0 && !rmap_argument(given, "of"))
        *kinds = (1u << RMAP_COMPARE_KIND_COUNT) - 1;
out:
    rmap_argument_list_free(list, n);
    return st;
}

enum rmap_status rmap_compare_request_read(const struct rmap_arguments *given,
                                           struct rmap_compare_request *request,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *correction = rmap_argument(given, "correction");
    size_t word = RMAP_CORRECTION_HOLM;
    bool one = given->n_operand == 1;
    *request =
        (struct rmap_compare_request){.path = {given->operand[0], given->operand[one ? 0 : 1]},
                                      .detector = rmap_argument(given, "detector"),
                                      .output_path = rmap_argument(given, "output"),
                                      .range = rmap_argument(given, "range"),
                                      .significance = 0.01};
    RMAP_TRY(rmap_argument_each(given, "where", &request->where, &request->n_where, err));
    RMAP_TRY(rmap_argument_each(given, "of", &request->of, &request->n_of, err));
    RMAP_TRY(rmap_argument_count(given, "bins", &request->n_bin, err));
    RMAP_TRY(read_kinds(given, &request->kinds, err));
    RMAP_TRY(rmap_argument_number(given, "significance", &request->significance, err));
    if (correction)
        RMAP_TRY(find_word(correction, "correction", rmap_correction_word, &word, err));
    request->correction = (enum rmap_correction)word;
    if (!(request->significance > 0.0 && request->significance < 1.0))
        st = rmap_error_set(err, RMAP_USAGE,
                            "--significance must lie between 0 and 1, both excluded");
    else if (request->n_bin > RMAP_COMPARE_BINS_MAX ||
             (!request->n_bin && rmap_argument(given, "bins")))
        st = rmap_error_set(err, RMAP_USAGE, "--bins must lie between 1 and %d",
                            RMAP_COMPARE_BINS_MAX);
    else if (rmap_argument(given, "which") && !request->detector)
        st = rmap_error_set(err, RMAP_USAGE,
                            "--which chooses registrations on a detector: give --detector NAME");
    else if (request->n_where > 2)
        st = rmap_error_set(err, RMAP_USAGE, "at most two --where, for the two samples");
    else if (one && request->n_where != 2)
        st = rmap_error_set(err, RMAP_USAGE,
                            "one map alone: say which two criteria to compare, --where A --where B "
                            "(or name a second map)");
    else if (request->output_path && request->n_of > 1 &&
             !rmap_output_is(request->output_path, ".json"))
        st = rmap_error_set(
            err, RMAP_USAGE,
            "this file holds one distribution: one --of, or -o OUT.json for several");
    else if (request->output_path)
        st = rmap_output_check(request->output_path, rmap_compare_suffixes,
                               rmap_argument(given, "force") != NULL, err);
out:
    return st;
}

void rmap_compare_request_fini(struct rmap_compare_request *request)
{
    rmap_argument_list_free(request->where, request->n_where);
    rmap_argument_list_free(request->of, request->n_of);
}
