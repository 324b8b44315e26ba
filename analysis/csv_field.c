/* SPDX-License-Identifier: MIT */
#include "analysis/csv_field.h"

#include <math.h>

void rmap_csv_put_text(const char *text, FILE *out)
{
    fputs(",\"", out);
    for (; text && *text; text++)
        fprintf(out, *text == '"' ? "\"\"" : "%c", *text);
    fputc('"', out);
}

void rmap_csv_put_number(double value, FILE *out)
{
    fprintf(out, isfinite(value) ? ",%.17g" : ",", value);
}
