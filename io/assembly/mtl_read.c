/* SPDX-License-Identifier: MIT
 *
 * Wavefront .mtl: colours and what is clear, a first guess of what things are made of.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/assembly/assembly.h"
#include "io/lensfile/lens_text.h"

enum { MATERIALS_MAX = 10000 };

static double share(double value)
{
    return fmin(fmax(value, 0), 1);
}

static void read_line(struct rmap_assembly_material *to, char *const *word, size_t n)
{
    const double value = rmap_lens_value(word, n, 1, 0);
    if (rmap_lens_is(word[0], "Kd") && n >= 4) {
        to->colour.given = true;
        for (size_t k = 0; k < 3; k++)
            to->colour.rgb[k] = share(rmap_lens_value(word, n, 1 + k, 0));
    } else if (rmap_lens_is(word[0], "d")) {
        to->transmission = 1 - share(value);
    } else if (rmap_lens_is(word[0], "Tr")) {
        to->transmission = share(value);
    } else if (rmap_lens_is(word[0], "Ni") && value > 1 && value < 10) {
        to->index = value;
    } else if (rmap_lens_is(word[0], "Pm")) {
        to->metalness = share(value);
    } else if (rmap_lens_is(word[0], "Pr")) {
        to->roughness = share(value);
    }
}

enum rmap_status rmap_assembly_read_mtl(char *text, struct rmap_assembly *a, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lens_lines lines = {.at = text};
    char *word[RMAP_LENS_WORDS_MAX];
    while (rmap_lens_next_line(&lines)) {
        char *name = strncmp(lines.line, "newmtl ", 7) == 0 ? lines.line + 7 : NULL;
        if (name) {
            name += strspn(name, " \t");
            if (a->n_material >= MATERIALS_MAX)
                return rmap_error_set(err, RMAP_INPUT, "it has more than %d materials",
                                      MATERIALS_MAX);
            RMAP_TRY(RMAP_RESERVE(a->material, a->cap_material, a->n_material + 1, err));
            a->material[a->n_material] = (struct rmap_assembly_material){
                .name = rmap_strdup(name), .roughness = 1, .index = 1.5};
            if (!a->material[a->n_material].name)
                return rmap_error_set(err, RMAP_SYSTEM, "out of memory for materials");
            a->n_material++;
            continue;
        }
        const size_t n = rmap_lens_words(lines.line, "", word);
        if (n >= 2 && a->n_material > 0)
            read_line(&a->material[a->n_material - 1], word, n);
    }
out:
    return st;
}
