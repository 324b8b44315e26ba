/* SPDX-License-Identifier: MIT
 *
 * An assembly as the text of a scene.
 */
#include "io/assembly/assembly_scene.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/assembly/assembly_guess.h"
#include "io/assembly/assembly_place.h"
#include "io/lensfile/lens_text.h"
#include "io/lensfile/lens_write.h"

enum { LOOKS_MAX = 32, INDENT = 2, WORD_NBYTES = 400, BY_FACE_MAX = 16 };

/* ---- words ---- */

/* A name as YAML has it; labels have neither quotes nor blanks. */
static void put_name(FILE *out, const char *name)
{
    static const char *const other[] = {"true", "false", "yes", "no", "on", "off", "null", "nan"};
    bool plain = isalpha((unsigned char)name[0]) || name[0] == '_' || (name[0] & 0x80);
    for (const char *at = name; *at; at++)
        plain &= isalnum((unsigned char)*at) || strchr("_.-+", *at) || (*at & 0x80);
    for (size_t i = 0; i < sizeof other / sizeof *other; i++)
        plain &= strcasecmp(name, other[i]) != 0;
    (void)fprintf(out, plain ? "%s" : "'%s'", name);
}

/* The file's own words, in quotes. */
static void put_quoted(FILE *out, const char *text)
{
    char words[WORD_NBYTES];
    rmap_lens_copy(words, sizeof words, text);
    (void)fputc('\'', out);
    for (const char *at = words; *at; at++) {
        if (*at == '\'')
            (void)fputc('\'', out);
        (void)fputc(*at, out);
    }
    (void)fputc('\'', out);
}

static void put_geometry_name(FILE *out, const struct rmap_assembly_shape *shape)
{
    char name[WORD_NBYTES];
    (void)snprintf(name, sizeof name, "%.*s", (int)(strlen(shape->file) - strlen(".ply")),
                   shape->file);
    put_name(out, name);
}

/* ---- looks ---- */

/* That of the part, or what most of its faces have. */
static struct rmap_assembly_colour colour_of(const struct rmap_assembly *a,
                                             const struct rmap_assembly_part *part)
{
    const struct rmap_assembly_shape *shape = &a->shape[part->shape];
    struct rmap_assembly_colour most = part->colour;
    size_t lead = 0;
    /* Boyer and Moore's majority vote. */
    for (size_t i = 0; !part->colour.given && i < shape->n_face; i++) {
        const struct rmap_assembly_colour *its = &shape->face[i].colour;
        if (lead == 0)
            most = *its;
        const bool same =
            its->given == most.given && memcmp(its->rgb, most.rgb, sizeof most.rgb) == 0;
        lead = lead == 0 || same ? lead + 1 : lead - 1;
    }
    return most;
}

/* What a part, and which of its faces, are taken to be. */
struct looks {
    struct rmap_assembly_colour colour;
    struct rmap_assembly_guess whole, other[LOOKS_MAX];
    struct rmap_assembly_colour other_colour[LOOKS_MAX];
    size_t n_other;
};

/* Place among the others, LOOKS_MAX: as the whole. */
static size_t look_of(const struct rmap_assembly *a, const struct rmap_assembly_part *part,
                      const struct rmap_assembly_face *face, struct looks *looks)
{
    const struct rmap_assembly_shape *shape = &a->shape[part->shape];
    const bool own = face->material && face->material[0];
    const struct rmap_assembly_colour *colour = face->colour.given ? &face->colour : &looks->colour;
    struct rmap_assembly_guess guess;
    if (!own && (!face->colour.given || looks->whole.inside[0]))
        return LOOKS_MAX;
    rmap_assembly_guess(a, own ? face->material : part->material, colour, shape->closed && own,
                        &guess);
    if (strcmp(guess.surface, looks->whole.surface) == 0 ||
        (strcmp(guess.surface, "fresnel") == 0 && !looks->whole.inside[0]))
        return LOOKS_MAX; /* glass is all of a body, or nothing of it */
    for (size_t i = 0; i < looks->n_other; i++)
        if (strcmp(looks->other[i].surface, guess.surface) == 0)
            return i;
    if (looks->n_other == LOOKS_MAX)
        return LOOKS_MAX;
    looks->other[looks->n_other] = guess;
    looks->other_colour[looks->n_other] = *colour;
    return looks->n_other++;
}

static void find_looks(const struct rmap_assembly *a, const struct rmap_assembly_part *part,
                       struct looks *looks)
{
    const struct rmap_assembly_shape *shape = &a->shape[part->shape];
    looks->n_other = 0;
    looks->colour = colour_of(a, part);
    rmap_assembly_guess(a, part->material, &looks->colour, shape->closed, &looks->whole);
    for (size_t i = 0; i < shape->n_face; i++)
        (void)look_of(a, part, &shape->face[i], looks);
}

/* ---- parts ---- */

static void put_colour(FILE *out, const struct rmap_assembly_colour *colour)
{
    char text[8];
    if (!colour->given)
        return;
    rmap_assembly_hexadecimal(colour, text);
    (void)fprintf(out, ", color: '%s'", text);
}

/* "0, 3..5" */
static void put_ranges(FILE *out, const struct rmap_assembly *a,
                       const struct rmap_assembly_part *part, struct looks *looks, size_t look)
{
    const struct rmap_assembly_shape *shape = &a->shape[part->shape];
    const char *before = "";
    for (size_t i = 0, end; i < shape->n_face; i = end + 1) {
        for (end = i; end < shape->n_face && look_of(a, part, &shape->face[end], looks) == look;)
            end++;
        if (end == i)
            continue;
        (void)fprintf(out, end - i == 1 ? "%s%zu" : "%s%zu..%zu", before, i, end - 1);
        before = ", ";
    }
}

static void put_faces(FILE *out, const struct rmap_assembly *a,
                      const struct rmap_assembly_part *part, struct looks *looks)
{
    for (size_t k = 0; k < looks->n_other; k++) {
        (void)fputs(k ? ", {faces: [" : ", faces: [{faces: [", out);
        put_ranges(out, a, part, looks, k);
        (void)fprintf(out, "], surface: %s", looks->other[k].surface);
        put_colour(out, &looks->other_colour[k]);
        (void)fputc('}', out);
    }
    if (looks->n_other > 0)
        (void)fputc(']', out);
}

static void put_remark(FILE *out, const struct rmap_assembly_part *part)
{
    if (strcmp(part->label, part->name) != 0 && part->name[0]) {
        (void)fputs("   # ", out);
        rmap_lens_put_words(out, part->name);
    }
    (void)fputc('\n', out);
}

static void put_id(FILE *out, const struct rmap_assembly_part *part)
{
    (void)fprintf(out, "id: 0x%016" PRIx64, part->number);
}

static void put_part(FILE *out, const struct rmap_assembly *a,
                     const struct rmap_assembly_part *part, int depth, double reach)
{
    struct looks looks;
    const size_t n_face = a->shape[part->shape].n_face;
    find_looks(a, part, &looks);
    (void)fprintf(out, "%*s- {name: ", depth * 2 * INDENT + INDENT, "");
    put_name(out, part->label);
    (void)fputs(", ", out);
    put_id(out, part);
    (void)fputs(", geometry: ", out);
    put_geometry_name(out, &a->shape[part->shape]);
    rmap_assembly_put_place(out, ", ", &part->place, reach);
    (void)fprintf(out, ", surface: %s", looks.whole.surface);
    if (looks.whole.inside[0]) {
        (void)fputs(", inside: ", out);
        put_quoted(out, looks.whole.inside);
    }
    (void)fputs(", outside: air", out);
    put_colour(out, &looks.colour);
    if (part->material && part->material[0]) {
        (void)fputs(", material: ", out);
        put_quoted(out, part->material);
    }
    /* Ghosts are told by the faces that make them. */
    if (looks.whole.inside[0] && n_face > 1 && n_face <= BY_FACE_MAX)
        (void)fputs(", by_face: true", out);
    put_faces(out, a, part, &looks);
    (void)fputc('}', out);
    put_remark(out, part);
}

static void put_group(FILE *out, const struct rmap_assembly_part *part, int depth, double reach)
{
    const int indent = depth * 2 * INDENT + INDENT;
    char before[8 * RMAP_ASSEMBLY_DEPTH_MAX];
    (void)snprintf(before, sizeof before, "\n%*s", indent + INDENT, "");
    (void)fprintf(out, "%*s- name: ", indent, "");
    put_name(out, part->label);
    put_remark(out, part);
    (void)fprintf(out, "%*s", indent + INDENT, "");
    put_id(out, part);
    rmap_assembly_put_place(out, before, &part->place, reach);
    (void)fprintf(out, "\n%*sobjects:\n", indent + INDENT, "");
}

static enum rmap_status put_tree(FILE *out, const struct rmap_assembly *a, struct rmap_error *err)
{
    int *depth = rmap_alloc(a->n_part, sizeof *depth);
    struct rmap_vec3 lower = {0, 0, 0}, upper = {0, 0, 0};
    (void)rmap_assembly_bounds(a, &lower, &upper);
    const double reach = rmap_length(rmap_sub(upper, lower));
    if (!depth)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", a->n_part);
    for (size_t i = 0; i < a->n_part; i++) {
        const struct rmap_assembly_part *part = &a->part[i];
        const bool empty = i + 1 == a->n_part || a->part[i + 1].parent != (int32_t)i;
        depth[i] = part->parent < 0 ? 0 : depth[part->parent] + 1;
        if (part->shape >= 0)
            put_part(out, a, part, depth[i], reach);
        else
            put_group(out, part, depth[i], reach);
        if (part->shape < 0 && empty)
            (void)fprintf(out, "%*s[]\n", depth[i] * 2 * INDENT + 3 * INDENT, "");
    }
    rmap_free(depth);
    return RMAP_OK;
}

/* ---- surfaces and media ---- */

struct words {
    char (*word)[RMAP_GUESS_NBYTES];
    size_t n, cap;
};

static int by_text(const void *a, const void *b)
{
    return strcmp(a, b);
}

static enum rmap_status add_word(struct words *words, const char *word, struct rmap_error *err)
{
    if (RMAP_RESERVE(words->word, words->cap, words->n + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    (void)snprintf(words->word[words->n++], RMAP_GUESS_NBYTES, "%s", word);
    return RMAP_OK;
}

static void sort_words(struct words *words)
{
    size_t n = 0;
    if (words->n > 0)
        qsort(words->word, words->n, sizeof *words->word, by_text);
    for (size_t i = 0; i < words->n; i++)
        if (n == 0 || strcmp(words->word[n - 1], words->word[i]) != 0)
            memmove(words->word[n++], words->word[i], sizeof *words->word);
    words->n = n;
}

static enum rmap_status put_looks(FILE *out, const struct rmap_assembly *a, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct words surface = {0}, medium = {0};
    struct looks looks;
    bool any = false;
    for (size_t i = 0; i < a->n_part; i++) {
        if (a->part[i].shape < 0)
            continue;
        find_looks(a, &a->part[i], &looks);
        RMAP_TRY(add_word(&surface, looks.whole.surface, err));
        for (size_t k = 0; k < looks.n_other; k++)
            RMAP_TRY(add_word(&surface, looks.other[k].surface, err));
        if (rmap_assembly_put_medium(NULL, looks.whole.inside))
            RMAP_TRY(add_word(&medium, looks.whole.inside, err));
    }
    sort_words(&surface);
    sort_words(&medium);
    if (medium.n > 0)
        (void)fputs("media:\n", out);
    for (size_t i = 0; i < medium.n; i++)
        (void)rmap_assembly_put_medium(out, medium.word[i]);
    for (size_t i = 0; i < surface.n; i++) {
        if (strcmp(surface.word[i], "fresnel") == 0)
            continue;
        (void)fputs(any ? "" : "surfaces:\n", out);
        rmap_assembly_put_surface(out, surface.word[i]);
        any = true;
    }
out:
    rmap_free(surface.word);
    rmap_free(medium.word);
    return st;
}

static void put_geometries(FILE *out, const struct rmap_assembly *a)
{
    (void)fputs("geometries:\n", out);
    for (size_t i = 0; i < a->n_shape; i++) {
        const struct rmap_assembly_shape *shape = &a->shape[i];
        (void)fputs("  ", out);
        put_geometry_name(out, shape);
        (void)fprintf(out, ": {type: mesh, file: " RMAP_ASSEMBLY_MESHES "/%s, scale: mm}   # ",
                      shape->file);
        rmap_lens_put_words(out, shape->name);
        (void)fprintf(out, "%s%zu face%s, %s, %.4g x %.4g x %.4g mm\n", shape->name[0] ? ": " : "",
                      shape->n_face, shape->n_face == 1 ? "" : "s",
                      shape->closed ? "closed" : "open", shape->upper[0] - shape->lower[0],
                      shape->upper[1] - shape->lower[1], shape->upper[2] - shape->lower[2]);
    }
}

enum rmap_status rmap_assembly_put_parts(const void *context, FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_assembly *a = context;
    (void)fputs("# Parts of ", out);
    rmap_lens_put_words(out, a->source);
    (void)fputs(
        ", which `raymap update` writes anew for each revision of it: surfaces and media of\n"
        "# parts are given by rules in " RMAP_ASSEMBLY_ATTRIBUTES
        ", all else stands in scene.yaml.\n"
        "# Colours and materials are the file's; surfaces are guessed by them.\nraymap: 1\n",
        out);
    RMAP_TRY(put_looks(out, a, err));
    put_geometries(out, a);
    (void)fputs("objects:\n", out);
    st = put_tree(out, a, err);
out:
    return st;
}

/* ---- the user's files ---- */

/* "#   '#cc3300': 12 parts, bracket and others" */
static void put_example(FILE *out, const struct rmap_assembly *a, const char *key, const char *word,
                        size_t n, size_t first)
{
    (void)fprintf(out, "#   %s ", key);
    put_quoted(out, word);
    (void)fprintf(out, ": %s", a->part[first].label);
    if (n > 1)
        (void)fprintf(out, " and %zu other%s", n - 1, n == 2 ? "" : "s");
    (void)fputc('\n', out);
}

struct mention {
    char word[WORD_NBYTES];
    size_t part;
};

static int by_mention(const void *a, const void *b)
{
    const struct mention *x = a, *y = b;
    const int order = strcmp(x->word, y->word);
    return order ? order : (x->part > y->part) - (x->part < y->part);
}

/* What rules can go by, each once. */
static enum rmap_status put_mentions(FILE *out, const struct rmap_assembly *a, bool materials,
                                     struct rmap_error *err)
{
    enum { MOST = 200 };
    size_t n = 0, told = 0;
    struct mention *list = rmap_alloc(a->n_part, sizeof *list);
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", a->n_part);
    for (size_t i = 0; i < a->n_part; i++) {
        const struct rmap_assembly_part *part = &a->part[i];
        if (part->shape < 0)
            continue;
        const struct rmap_assembly_colour colour = colour_of(a, part);
        if (materials && part->material)
            (void)snprintf(list[n].word, WORD_NBYTES, "%s", part->material);
        else if (!materials && colour.given)
            rmap_assembly_hexadecimal(&colour, list[n].word);
        list[n].part = i;
        n += list[n].word[0] != 0;
    }
    if (n > 0)
        qsort(list, n, sizeof *list, by_mention);
    for (size_t i = 0, end; i < n && told < MOST; i = end, told++) {
        for (end = i; end < n && strcmp(list[end].word, list[i].word) == 0;)
            end++;
        put_example(out, a, materials ? "material" : "color", list[i].word, end - i, list[i].part);
    }
    rmap_free(list);
    return RMAP_OK;
}

enum rmap_status rmap_assembly_put_attributes(const void *context, FILE *out,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_assembly *a = context;
    (void)fputs("# Optical attributes of the parts of ", out);
    rmap_lens_put_words(out, a->source);
    (void)fputs(", by rules: this file is yours, `raymap update` keeps it.\n"
                "# Rules are read in their order; a later one counts where two set the same. They "
                "match by\n"
                "# name, group, id, material, color (within a tolerance) and face, with patterns "
                "of * and ?,\n"
                "# and set surface, inside, outside (media), by_face (an object for each face, as\n"
                "# tables of ghosts want it) or omit. For example:\n"
                "#\n"
                "# surfaces:\n"
                "#   black: {type: lambert, reflectance: 0.04}\n"
                "# attributes:\n"
                "#   - {match: {name: 'lens*'}, set: {surface: fresnel, inside: N-BK7, by_face: "
                "true}}\n"
                "#   - {match: {name: 'lens*', face: [rim, 3..5]}, set: {surface: black}}\n"
                "#   - {match: {group: housing, color: '#202020'}, set: {surface: black}}\n"
                "#   - {match: {name: 'screw*'}, set: {omit: true}}\n"
                "#\n"
                "# What the file has (names: " RMAP_ASSEMBLY_PARTS "):\n",
                out);
    RMAP_TRY(put_mentions(out, a, true, err));
    RMAP_TRY(put_mentions(out, a, false, err));
    (void)fputs("attributes: []\n", out);
out:
    return st;
}

bool rmap_assembly_bounds(const struct rmap_assembly *a, struct rmap_vec3 *lower,
                          struct rmap_vec3 *upper)
{
    bool any = false;
    for (size_t i = 0; i < a->n_part; i++) {
        if (a->part[i].shape < 0)
            continue;
        const struct rmap_assembly_shape *shape = &a->shape[a->part[i].shape];
        const struct rmap_affine world = rmap_assembly_world(a, i);
        for (int k = 0; k < 8; k++) {
            const struct rmap_vec3 p =
                rmap_affine_point(&world, rmap_vec3((k & 1 ? shape->upper : shape->lower)[0],
                                                    (k & 2 ? shape->upper : shape->lower)[1],
                                                    (k & 4 ? shape->upper : shape->lower)[2]));
            *lower = any ? rmap_least(*lower, p) : p;
            *upper = any ? rmap_greatest(*upper, p) : p;
            any = true;
        }
    }
    return any;
}

/* From the front, right and above, the whole of it; to four digits. */
static void put_camera(FILE *out, struct rmap_vec3 lower, struct rmap_vec3 upper)
{
    const struct rmap_vec3 middle = rmap_scale(rmap_add(lower, upper), 0.5);
    const double size = fmax(rmap_length(rmap_sub(upper, lower)), 1e-6);
    const struct rmap_vec3 from = rmap_normalize(rmap_vec3(0.55, -1, 0.6));
    const double half_fov = RMAP_PI / 12, away = 0.5 * size / sin(half_fov);
    const struct rmap_vec3 at = rmap_axpy(away, from, middle);
    (void)fprintf(out,
                  "background: {radiance: 1, trace: false}\ncameras:\n"
                  "  - {name: view, at: [%.5g, %.5g, %.5g], look_at: [%.5g, %.5g, %.5g], fov: 30, "
                  "resolution: [800, 600]}\n",
                  at.x, at.y, at.z, middle.x, middle.y, middle.z);
}

/* Sums of places are off by rounding where the model says 0. */
static struct rmap_vec3 without_rounding(struct rmap_vec3 v, double size)
{
    const double least = 1e-12 * size;
    return rmap_vec3(fabs(v.x) < least ? 0 : v.x, fabs(v.y) < least ? 0 : v.y,
                     fabs(v.z) < least ? 0 : v.z);
}

enum rmap_status rmap_assembly_put_scene(const void *context, FILE *out, struct rmap_error *err)
{
    const struct rmap_assembly *a = context;
    struct rmap_vec3 lower = {0, 0, 0}, upper = {0, 0, 0};
    size_t n = 0;
    (void)err;
    (void)rmap_assembly_bounds(a, &lower, &upper);
    const double size = rmap_length(rmap_sub(upper, lower));
    lower = without_rounding(lower, size);
    upper = without_rounding(upper, size);
    for (size_t i = 0; i < a->n_part; i++)
        n += a->part[i].shape >= 0;
    (void)fputs("# Imported from ", out);
    rmap_lens_put_words(out, a->source);
    (void)fputs(" (", out);
    rmap_lens_put_words(out, a->schema);
    if (a->writer[0])
        (void)fputs(", ", out);
    rmap_lens_put_words(out, a->writer);
    (void)fputs(a->file_unit[0] ? ", in " : "", out);
    rmap_lens_put_words(out, a->file_unit);
    (void)fprintf(out,
                  ") by `raymap import`: %zu part%s of %zu shape%s, in a box from\n"
                  "# (%.5g, %.5g, %.5g) to (%.5g, %.5g, %.5g) mm.\n"
                  "# This file and " RMAP_ASSEMBLY_ATTRIBUTES " are yours. " RMAP_ASSEMBLY_PARTS
                  " and " RMAP_ASSEMBLY_MESHES
                  "/ are made of the model, and anew\n# by `raymap update`.\n",
                  n, n == 1 ? "" : "s", a->n_shape, a->n_shape == 1 ? "" : "s", lower.x, lower.y,
                  lower.z, upper.x, upper.y, upper.z);
    (void)fputs("raymap: 1\nunits: mm\ninclude: [" RMAP_ASSEMBLY_PARTS ", " RMAP_ASSEMBLY_ATTRIBUTES
                "]\nmedia:\n  air: {index: 1}\n\n"
                "# Light, and what is to see it, as in:\n",
                out);
    (void)fprintf(out,
                  "# sources:\n#   - {name: lamp, type: point, at: [%.4g, %.4g, %.4g], "
                  "direction: [0, 0, -1], distribution: {cone: 20}, flux: 1 W}\n"
                  "# detectors:\n#   - {name: sensor, type: plane, at: [%.4g, %.4g, %.4g], "
                  "size: [%.3g, %.3g], cells: [100, 100]}\n",
                  0.5 * (lower.x + upper.x), 0.5 * (lower.y + upper.y), upper.z + size,
                  0.5 * (lower.x + upper.x), 0.5 * (lower.y + upper.y), lower.z - 0.1 * size,
                  0.5 * size, 0.5 * size);
    (void)fputs("\n# What `raymap render` sees: the model under an even sky.\n", out);
    put_camera(out, lower, upper);
    return RMAP_OK;
}
