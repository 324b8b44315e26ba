/* SPDX-License-Identifier: MIT
 *
 * Fields of CSV (RFC 4180): texts stand in quotes where they must, with a comma, a quote or a
 * line's end in them; NULL is an empty text.
 */
#include "analysis/table/csv_field.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

bool rmap_csv_needs_quotes(const char *text)
{
    return strpbrk(text, ",\"\r\n") != NULL;
}

void rmap_csv_put_inside(const char *text, FILE *out)
{
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', out);
        fputc(*text, out);
    }
}

void rmap_csv_put_first(const char *text, FILE *out)
{
    if (!text)
        return;
    const char *quote = rmap_csv_needs_quotes(text) ? "\"" : "";
    fputs(quote, out);
    rmap_csv_put_inside(text, out);
    fputs(quote, out);
}

void rmap_csv_put_text(const char *text, FILE *out)
{
    fputc(',', out);
    rmap_csv_put_first(text, out);
}

void rmap_csv_put_number(double value, FILE *out)
{
    fprintf(out, isfinite(value) ? ",%.17g" : ",", value);
}

void rmap_csv_put_estimate(double value, double standard_error, FILE *out)
{
    fprintf(out, isfinite(value) ? ",%.10g" : ",", value);
    fprintf(out, isfinite(standard_error) ? ",%.7g" : ",", standard_error);
}
