/* SPDX-License-Identifier: MIT
 *
 * Materials of the catalogue that are asked for.
 */
#include "mpi/answer/glass_list.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/glob.h"
#include "io/export/json_number.h"
#include "io/scene/glass_nearest.h"

enum { NAME_MAX_LEN = 64 };
#define PATH_MM 10.0

static void fold_case(const char *from, char to[NAME_MAX_LEN])
{
    size_t n = 0;
    for (; from[n] && n + 1 < NAME_MAX_LEN; n++)
        to[n] = from[n] == ':' ? ' ' : (char)tolower((unsigned char)from[n]);
    to[n] = 0;
}

/* The name alone, or behind its group. */
static bool matches(const char *pattern, const char *group, const char *name)
{
    char folded[NAME_MAX_LEN], text[NAME_MAX_LEN], whole[NAME_MAX_LEN];
    fold_case(pattern, folded);
    fold_case(name, text);
    if (rmap_glob(folded, text))
        return true;
    (void)snprintf(whole, sizeof whole, "%s %s", group, name);
    fold_case(whole, text);
    return rmap_glob(folded, text);
}

double rmap_glass_distance(double nd, double vd, double other_nd, double other_vd)
{
    return hypot((other_nd - nd) / 0.001, (other_vd - vd) / (0.01 * vd));
}

/* As published, else of the data; films and metals have no vd. */
static void name_numbers(const struct rmap_glass *glass, double *nd, double *vd)
{
    const bool inside = glass->from_nm <= RMAP_LINE_D_NM && glass->to_nm >= RMAP_LINE_D_NM;
    *nd = !isnan(glass->nd) ? glass->nd
          : inside          ? rmap_glass_index(glass, RMAP_LINE_D_NM)
                            : (double)NAN;
    *vd = !isnan(glass->vd) || glass->linear ? glass->vd : rmap_glass_abbe(glass);
}

static enum rmap_status refuse_unknown(const char *name, struct rmap_error *err)
{
    char nearest[160];
    (void)rmap_glass_nearest(name, nearest, sizeof nearest);
    return rmap_error_set(err, RMAP_INPUT, "unknown glass '%.60s'%s%s%s", name,
                          *nearest ? " (did you mean " : ": patterns such as 'N-LAK*' list glasses",
                          nearest, *nearest ? "?)" : "");
}

static enum rmap_status check_patterns(const struct rmap_glass_request *request, const bool *hit,
                                       struct rmap_error *err)
{
    for (size_t i = 0; i < request->n_pattern; i++)
        if (!hit[i] && !strpbrk(request->pattern[i], "*?"))
            return refuse_unknown(request->pattern[i], err);
    return RMAP_OK;
}

static bool is_asked_for(const struct rmap_glass_request *request,
                         const struct rmap_catalogue *place, bool *hit)
{
    char name[32], group[16];
    bool wanted = request->n_pattern == 0;
    rmap_catalogue_name(place, name, group);
    for (size_t i = 0; i < request->n_pattern; i++)
        if (matches(request->pattern[i], group, name))
            hit[i] = wanted = true;
    return wanted;
}

/* Keeps the nearest of them, in their order. */
static void insert_near(const struct rmap_glass_request *request,
                        const struct rmap_catalogue *place, struct rmap_glass_list *list)
{
    struct rmap_glass glass;
    double nd, vd;
    rmap_catalogue_read(place, &glass);
    name_numbers(&glass, &nd, &vd);
    double distance = rmap_glass_distance(request->near_nd, request->near_vd, nd, vd);
    size_t at = list->n;
    while (at > 0 && list->distance[at - 1] > distance)
        at--;
    if (isnan(distance) || at == request->most)
        return;
    list->n += list->n < request->most;
    for (size_t i = list->n - 1; i > at; i--) {
        list->place[i] = list->place[i - 1];
        list->distance[i] = list->distance[i - 1];
    }
    list->place[at] = *place;
    list->distance[at] = distance;
}

enum rmap_status rmap_glass_list_make(const struct rmap_glass_request *request,
                                      struct rmap_glass_list *list, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_catalogue place = {0};
    size_t n_all = 0;
    bool *hit = rmap_alloc(request->n_pattern + 1, sizeof *hit);
    *list = (struct rmap_glass_list){0};
    while (rmap_catalogue_next(&place))
        n_all++;
    list->place = rmap_alloc(n_all, sizeof *list->place);
    list->distance = request->is_near ? rmap_alloc(n_all, sizeof *list->distance) : NULL;
    if (!hit || !list->place || (request->is_near && !list->distance)) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of glasses");
        goto out;
    }
    for (place = (struct rmap_catalogue){0}; rmap_catalogue_next(&place);) {
        if (!is_asked_for(request, &place, hit))
            continue;
        if (request->is_near)
            insert_near(request, &place, list);
        else
            list->place[list->n++] = place;
    }
    st = check_patterns(request, hit, err);
out:
    if (st != RMAP_OK)
        rmap_glass_list_fini(list);
    rmap_free(hit);
    return st;
}

void rmap_glass_list_fini(struct rmap_glass_list *list)
{
    rmap_free(list->place);
    rmap_free(list->distance);
    *list = (struct rmap_glass_list){0};
}

/* A number in a column, or a dash where there is none. */
static void put(double value, int width, int decimals, FILE *out)
{
    if (isnan(value))
        fprintf(out, " %*s", width, "-");
    else
        fprintf(out, " %*.*f", width, decimals, value);
}

static const double usual_nm[] = {400.0, 550.0};

static void print_head(const struct rmap_glass_request *request, bool is_near, FILE *out)
{
    char text[32];
    fprintf(out, "%-8s %-14s %8s %6s %6s %6s", "group", "name", "nd", "vd", "from", "to nm");
    for (size_t i = 0; i < request->n_at; i++) {
        (void)snprintf(text, sizeof text, "n %g", request->at_nm[i]);
        fprintf(out, " %9s", text);
    }
    for (size_t i = 0; !request->n_at && i < 2; i++) {
        (void)snprintf(text, sizeof text, "T10 %g", usual_nm[i]);
        fprintf(out, " %8s", text);
    }
    fprintf(out, "%s\n", is_near ? " distance" : "");
}

static double index_inside(const struct rmap_glass *glass, double nm)
{
    return nm >= glass->from_nm && nm <= glass->to_nm ? rmap_glass_index(glass, nm) : (double)NAN;
}

static void print_line(const struct rmap_glass_request *request, const struct rmap_glass *glass,
                       FILE *out)
{
    double nd, vd;
    name_numbers(glass, &nd, &vd);
    fprintf(out, "%-8s %-14s", glass->group, glass->name);
    put(nd, 8, 5, out);
    put(vd, 6, 2, out);
    fprintf(out, " %6.0f %6.0f", glass->from_nm, glass->to_nm);
    for (size_t i = 0; i < request->n_at; i++) {
        put(index_inside(glass, request->at_nm[i]), 9, 6, out);
        if (glass->linear)
            fprintf(out, " + %.4gi", rmap_glass_extinction(glass, request->at_nm[i]));
    }
    for (size_t i = 0; !request->n_at && i < 2; i++)
        put(rmap_glass_transmittance(glass, usual_nm[i], PATH_MM), 8, 4, out);
}

/* Lines of mercury, hydrogen, helium, cadmium, sodium, caesium (ISO 7944) and lasers. */
static const struct {
    const char *name;
    double nm;
} spectral_line[] = {{"i", 365.0146}, {"h", 404.6561},  {"g", 435.8343},  {"F'", 479.9914},
                     {"F", 486.1327}, {"Ar+", 514.5},   {"e", 546.074},   {"d", 587.5618},
                     {"D", 589.2938}, {"He-Ne", 632.8}, {"C'", 643.8469}, {"C", 656.2725},
                     {"r", 706.5188}, {"s", 852.11},    {"t", 1013.98},   {"Nd:YAG", 1064.0},
                     {"Er", 1550.0},  {"Hg", 2325.42},  {"", 4000.0},     {"CO2", 10600.0}};

static void print_single(const struct rmap_glass *glass, FILE *out)
{
    fprintf(out, "\n%s\n", glass->source);
    if (glass->formula) {
        fprintf(out, "formula %d:", glass->formula);
        for (size_t i = 0; i < glass->n_coefficient; i++)
            fprintf(out, " %.9g", glass->coefficient[i]);
        fputc('\n', out);
    } else
        fprintf(out, "a table of %zu wavelengths\n", glass->index.n);
    fprintf(out, "\n%-6s %9s %9s %9s %12s %8s\n", "line", "nm", "n", "group", "k", "T10");
    for (size_t i = 0; i < sizeof spectral_line / sizeof *spectral_line; i++) {
        const double nm = spectral_line[i].nm;
        if (nm < glass->from_nm || nm > glass->to_nm)
            continue;
        double transmittance = rmap_glass_transmittance(glass, nm, PATH_MM);
        fprintf(out, "%-6s %9.2f %9.6f %9.6f", spectral_line[i].name, nm,
                rmap_glass_index(glass, nm), rmap_glass_group_index(glass, nm));
        if (isnan(transmittance))
            fprintf(out, " %12s", "-");
        else
            fprintf(out, " %12.4g", rmap_glass_extinction(glass, nm));
        put(transmittance, 8, 4, out);
        fputc('\n', out);
    }
}

void rmap_glass_list_print(const struct rmap_glass_request *request,
                           const struct rmap_glass_list *list, FILE *out)
{
    struct rmap_glass glass;
    if (list->n > 0)
        print_head(request, list->distance != NULL, out);
    for (size_t i = 0; i < list->n; i++) {
        rmap_catalogue_read(&list->place[i], &glass);
        print_line(request, &glass, out);
        if (list->distance)
            fprintf(out, " %8.2f", list->distance[i]);
        fputc('\n', out);
    }
    if (list->n == 1 && request->n_at == 0)
        print_single(&glass, out);
}

static json_t *at_json(const struct rmap_glass *glass, double nm)
{
    const double transmittance = rmap_glass_transmittance(glass, nm, PATH_MM);
    return json_pack(
        "{s:o, s:o, s:o, s:o, s:o}", "wavelength", rmap_json_number(nm), "n",
        rmap_json_number(index_inside(glass, nm)), "group_index",
        rmap_json_number(isnan(index_inside(glass, nm)) ? (double)NAN
                                                        : rmap_glass_group_index(glass, nm)),
        "k",
        rmap_json_number(isnan(transmittance) ? (double)NAN : rmap_glass_extinction(glass, nm)),
        "transmittance", rmap_json_number(transmittance));
}

json_t *rmap_glass_list_json(const struct rmap_glass_request *request,
                             const struct rmap_glass_list *list)
{
    const double *nm = request->n_at ? request->at_nm : usual_nm;
    const size_t n_nm = request->n_at ? request->n_at : 2;
    struct rmap_glass glass;
    json_t *glasses = json_array();
    for (size_t i = 0; i < list->n; i++) {
        double nd, vd;
        rmap_catalogue_read(&list->place[i], &glass);
        name_numbers(&glass, &nd, &vd);
        json_t *at = json_array();
        for (size_t k = 0; k < n_nm; k++)
            (void)json_array_append_new(at, at_json(&glass, nm[k]));
        json_t *one =
            json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:i, s:s, s:o}", "group", glass.group, "name",
                      glass.name, "nd", rmap_json_number(nd), "vd", rmap_json_number(vd), "from",
                      rmap_json_number(glass.from_nm), "to", rmap_json_number(glass.to_nm),
                      "formula", glass.formula, "source", glass.source, "at", at);
        if (one && list->distance)
            (void)json_object_set_new(one, "distance", rmap_json_number(list->distance[i]));
        (void)json_array_append_new(glasses, one);
    }
    return json_pack("{s:o}", "glasses", glasses);
}
