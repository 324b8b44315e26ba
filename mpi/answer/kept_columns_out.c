/* SPDX-License-Identifier: MIT
 *
 * The columns that a map keeps beside its pieces, as `keep` and `info` tell of them.
 */
#include "mpi/answer/kept_columns_out.h"

#include "base/grouped.h"

json_t *rmap_kept_columns_json(const struct rmap_columns_survey *survey)
{
    json_t *columns = json_array();
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (survey->columns & RMAP_COLUMN_BIT(c))
            (void)json_array_append_new(columns,
                                        json_string(rmap_column_info((enum rmap_column)c)->path));
    return json_pack("{s:o, s:I, s:I, s:I, s:I, s:s}", "columns", columns, "pieces",
                     (json_int_t)survey->n_piece, "of_pieces", (json_int_t)survey->n_compact,
                     "bytes", (json_int_t)survey->nbytes, "unused", (json_int_t)survey->n_unused,
                     "why", survey->why.text);
}

void rmap_kept_columns_print(const struct rmap_columns_survey *survey, FILE *out)
{
    if (survey->n_piece > 0) {
        fprintf(out, "  kept beside %zu of %s, %.1f MB:", survey->n_piece,
                rmap_counted(survey->n_compact, "piece").text, 1e-6 * (double)survey->nbytes);
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
            if (survey->columns & RMAP_COLUMN_BIT(c))
                fprintf(out, " %s", rmap_column_info((enum rmap_column)c)->path);
        fputc('\n', out);
    }
    if (survey->n_unused > 0)
        fprintf(out,
                "  kept columns of %s cannot be used: raymap keep --force makes them again (%s)\n",
                rmap_counted(survey->n_unused, "piece").text, survey->why.text);
}
