/* SPDX-License-Identifier: MIT
 *
 * Lamp makers' files of what was traced. IES LM-63 in its form of 1995, which all programs read and
 * which wants no date; EULUMDAT with one set of -1 lamps: absolute, of the luminaire's lumens.
 */
#include "io/lamp/lamp_file.h"

enum { TITLE_MAX = 70, IN_A_LINE = 10 };

static void put_title(const char *title, FILE *out)
{
    int n = 0;
    for (; *title && n < TITLE_MAX; title++)
        if (((unsigned char)*title & 0xc0) != 0x80) {
            fputc(*title >= ' ' && *title < 0x7f ? *title : '?', out);
            n++;
        }
}

static void put_numbers(const double *value, size_t n, FILE *out)
{
    for (size_t i = 0; i < n; i++)
        fprintf(out, "%s%.8g", i == 0 ? "" : i % IN_A_LINE == 0 ? "\r\n" : " ", value[i]);
    fputs("\r\n", out);
}

static void write_ies(const struct rmap_lamp_file *file, const struct rmap_lamp_words *words,
                      FILE *out)
{
    fputs("IESNA:LM-63-1995\r\n[TEST] traced by Raymap\r\n[MANUFAC]\r\n[LUMINAIRE] ", out);
    put_title(words->title, out);
    /* Readers take an angle of 360 for the sign that there is no symmetry. */
    fprintf(out, "\r\nTILT=NONE\r\n1 -1 1 %zu %zu 1 2 0 0 0\r\n1 1 0\r\n", file->n_polar,
            file->n_around > 1 ? file->n_around + 1 : 1);
    put_numbers(file->polar_deg, file->n_polar, out);
    for (size_t k = 0; k < file->n_around; k++)
        fprintf(out, "%.8g%s", file->around_deg[k], k % IN_A_LINE == IN_A_LINE - 1 ? "\r\n" : " ");
    fputs(file->n_around > 1 ? "360\r\n" : "\r\n", out);
    for (size_t k = 0; k < file->n_around; k++)
        put_numbers(file->candela + k * file->n_polar, file->n_polar, out);
    if (file->n_around > 1)
        put_numbers(file->candela, file->n_polar, out);
}

static double step_of(const double *angle, size_t n)
{
    return n > 1 ? angle[1] - angle[0] : 0.0;
}

static void write_eulumdat(const struct rmap_lamp_file *file, const struct rmap_lamp_words *words,
                           FILE *out)
{
    const bool round = file->n_around == 1;
    const double lumens = words->lumens;
    fprintf(out, "Raymap\r\n%d\r\n%d\r\n%zu\r\n%.8g\r\n%zu\r\n%.8g\r\n\r\n", round ? 1 : 3,
            round ? 1 : 0, file->n_around, step_of(file->around_deg, file->n_around), file->n_polar,
            step_of(file->polar_deg, file->n_polar));
    put_title(words->title, out);
    fputs("\r\n\r\n\r\n\r\n", out);
    for (int i = 0; i < 9; i++) /* lengths */
        fputs("0\r\n", out);
    fprintf(out, "%.4f\r\n100\r\n1\r\n0\r\n1\r\n-1\r\ntraced\r\n%.8g\r\n\r\n\r\n0\r\n",
            lumens > 0.0 ? 100.0 * words->down_lm / lumens : 0.0, lumens);
    for (int i = 0; i < 10; i++) /* direct ratios */
        fputs("0\r\n", out);
    for (size_t k = 0; k < file->n_around; k++)
        fprintf(out, "%.8g\r\n", file->around_deg[k]);
    for (size_t i = 0; i < file->n_polar; i++)
        fprintf(out, "%.8g\r\n", file->polar_deg[i]);
    for (size_t i = 0; i < file->n_around * file->n_polar; i++)
        fprintf(out, "%.8g\r\n", lumens > 0.0 ? 1000.0 * file->candela[i] / lumens : 0.0);
}

void rmap_lamp_file_write(const struct rmap_lamp_file *file, enum rmap_lamp_format format,
                          const struct rmap_lamp_words *words, FILE *out)
{
    (format == RMAP_LAMP_IES ? write_ies : write_eulumdat)(file, words, out);
}
