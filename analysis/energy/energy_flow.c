/* SPDX-License-Identifier: MIT
 *
 * An energy balance as boxes and bands: sources, groups of the scene where there are many objects,
 * and where the light ended.
 */
#include "analysis/energy/energy_flow.h"

#include <string.h>

#include "base/alloc.h"

enum {
    SOURCE_MAX = 16,
    GROUP_MAX = 8,
    MEDIUM_MAX = 4,
    FLAT_MAX = 12,
    GROUPED_MAX = 16,
    END_MAX = 48
};
enum { NAME_MAX_CHARACTERS = 30 };

/* Flows below this part of the whole are merged. */
static const double SMALLEST = 0.005;

/* A group's number where there is none. */
#define NO_GROUP SIZE_MAX
#define NO_END   SIZE_MAX

/* Where light ended, in the order of the picture. */
struct flow_end {
    char name[128];
    const char *colour;
    size_t group; /* its place among the shown groups, or NO_GROUP */
    double from[SOURCE_MAX + 1], sum;
};

struct flow {
    const struct rmap_energy *energy;
    const struct rmap_scene *scene;
    struct rmap_sankey *sankey;
    size_t n_source;    /* shown; the last may be the others */
    int32_t root;       /* groups right below it are shown; -1: those of the scene */
    size_t n_limit;     /* objects that are shown by themselves, at most */
    double *group_flux; /* [n_group + 1] of the objects in groups below root */
    size_t n_group;
    int32_t group[GROUP_MAX];
    size_t n_end;
    struct flow_end end[END_MAX];
    size_t *end_of_object, *end_of_medium; /* [n_object], [n_medium] */
    size_t end_of_other[4];                /* left, limit, error, heat */
};

static const char *const source_ink[SOURCE_MAX] = {
    "#f2b134", "#e8743b", "#c94f7c", "#6f9ceb", "#5bb5a2", "#a1c349", "#8d6e63", "#9575cd",
    "#a8720f", "#9c3f12", "#7c2a4a", "#2f5bb0", "#2b6f62", "#5f7a1c", "#4e342e", "#5e35b1"};
static const char *const ink[] = {"#4e79a7", "#76b7b2", "#59a14f", "#edc948",
                                  "#f28e2b", "#9c755f", "#ff9da7", "#1f9e89"};
static const char *const medium_ink = "#b07aa1", *const others_ink = "#b8b8b8";
static const char *const other_ink[4] = {"#8c96a3", "#d62728", "#7f1d1d", "#b8860b"};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* The group right below `root` that holds the object; -1: none. */
static int32_t group_below(const struct rmap_scene *scene, size_t object, int32_t root)
{
    int32_t group = scene->object[object].parent;
    while (group >= 0 && scene->group[group].parent != root)
        group = scene->group[group].parent;
    return group;
}

static size_t n_objects(const struct rmap_energy_table *table)
{
    size_t n = 0;
    while (n < table->n_row && table->row[n].end == RMAP_ENERGY_OBJECT)
        n++;
    return n;
}

/* Goes down the tree while one group holds all objects that absorbed light. */
static void choose_root(struct flow *flow)
{
    const struct rmap_energy_table *table = &flow->energy->table[0];
    const size_t n = n_objects(table);
    flow->root = -1;
    for (bool all = n > 0; all;) {
        int32_t first = group_below(flow->scene, table->row[0].index, flow->root);
        for (size_t i = 0; i < n && all; i++)
            all = first >= 0 && group_below(flow->scene, table->row[i].index, flow->root) == first;
        if (all)
            flow->root = first;
    }
}

/* The groups that took most, the most first; none where the objects are few. */
static void choose_groups(struct flow *flow)
{
    const struct rmap_energy_table *table = &flow->energy->table[0];
    const size_t n = n_objects(table);
    flow->n_limit = FLAT_MAX;
    if (n <= FLAT_MAX || flow->scene->n_group == 0)
        return;
    choose_root(flow);
    for (size_t i = 0; i < n; i++) {
        int32_t group = group_below(flow->scene, table->row[i].index, flow->root);
        if (group >= 0)
            flow->group_flux[group] += table->row[i].flux;
    }
    for (double *flux = flow->group_flux; flow->n_group < GROUP_MAX;) {
        size_t most = 0;
        for (size_t g = 1; g < flow->scene->n_group; g++)
            if (flux[g] > flux[most])
                most = g;
        if (!(flux[most] >= SMALLEST * table->flux) || !(flux[most] > 0.0))
            break;
        flow->group[flow->n_group++] = (int32_t)most;
        flux[most] = 0.0;
    }
    if (flow->n_group > 0)
        flow->n_limit = GROUPED_MAX;
}

static size_t shown_group(const struct flow *flow, size_t object)
{
    if (flow->n_group == 0)
        return NO_GROUP;
    int32_t group = group_below(flow->scene, object, flow->root);
    for (size_t g = 0; g < flow->n_group; g++)
        if (flow->group[g] == group)
            return g;
    return NO_GROUP;
}

/* At most `most` characters of UTF-8. */
static void shorten(const char *name, size_t most, char *text, size_t size)
{
    size_t at = 0, n = 0;
    for (; name[at] && at + 4 < size; at++) {
        n += ((unsigned char)name[at] & 0xc0) != 0x80;
        if (n > most)
            break;
        text[at] = name[at];
    }
    (void)snprintf(text + at, size - at, "%s", name[at] ? "…" : "");
}

static size_t add_end(struct flow *flow, const char *name, const char *colour, size_t group)
{
    if (flow->n_end == END_MAX) /* cannot be: the limits are less in all */
        return END_MAX - 1;
    struct flow_end *end = &flow->end[flow->n_end];
    shorten(name, NAME_MAX_CHARACTERS, end->name, sizeof end->name);
    end->colour = colour;
    end->group = group;
    return flow->n_end++;
}

/* The end of all of a group's objects that have none of their own. */
static void add_rest(struct flow *flow, size_t group)
{
    const struct rmap_energy_table *table = &flow->energy->table[0];
    size_t n_part = 0, end = add_end(flow, "", NULL, group);
    const char *only = "", *of = "objects";
    for (size_t i = 0; i < n_objects(table); i++) {
        const struct rmap_energy_row *row = &table->row[i];
        if (flow->end_of_object[row->index] == NO_END && shown_group(flow, row->index) == group) {
            flow->end_of_object[row->index] = end;
            only = row->name;
            n_part++;
        }
    }
    char name[256];
    if (group != NO_GROUP)
        of = flow->scene->group[flow->group[group]].name;
    (void)snprintf(name, sizeof name, group == NO_GROUP ? "%zu more %s" : "%zu more of %s", n_part,
                   of);
    shorten(n_part == 1 ? only : name, NAME_MAX_CHARACTERS, flow->end[end].name,
            sizeof flow->end[end].name);
    flow->end[end].colour = group == NO_GROUP ? others_ink : ink[group % COUNT(ink)];
}

/* Ends of the objects of a shown group, or of all others (NO_GROUP): one by one, then the rest. */
static void add_objects(struct flow *flow, size_t group)
{
    const struct rmap_energy_table *table = &flow->energy->table[0];
    bool rest = false;
    for (size_t i = 0; i < n_objects(table); i++) {
        const struct rmap_energy_row *row = &table->row[i];
        if (shown_group(flow, row->index) != group)
            continue;
        const bool alone = i < flow->n_limit && row->share >= SMALLEST;
        const size_t place = group == NO_GROUP ? flow->n_group + i : group;
        flow->end_of_object[row->index] =
            alone ? add_end(flow, row->name, ink[place % COUNT(ink)], group) : NO_END;
        rest = rest || !alone;
    }
    if (rest)
        add_rest(flow, group);
}

static void add_media(struct flow *flow)
{
    const struct rmap_energy_table *table = &flow->energy->table[0];
    size_t n = 0, rest = NO_END;
    char name[128];
    for (size_t i = n_objects(table); table->row[i].end == RMAP_ENERGY_MEDIUM; i++) {
        size_t end = rest;
        if (n++ < MEDIUM_MAX) {
            (void)snprintf(name, sizeof name, "in %s", table->row[i].name);
            end = add_end(flow, name, medium_ink, NO_GROUP);
        } else if (rest == NO_END) {
            end = rest = add_end(flow, "in other media", medium_ink, NO_GROUP);
        }
        flow->end_of_medium[table->row[i].index] = end;
    }
}

static void add_others(struct flow *flow)
{
    static const char *const name[4] = {"left the scene", "stopped by a limit", "stopped by errors",
                                        "heat"};
    const struct rmap_energy_table *table = &flow->energy->table[0];
    for (size_t i = 0; i < table->n_row; i++) {
        int which = (int)table->row[i].end - RMAP_ENERGY_LEFT;
        if (which >= 0 && table->row[i].rays > 0.0)
            flow->end_of_other[which] = add_end(flow, name[which], other_ink[which], NO_GROUP);
    }
}

static void add_flows(struct flow *flow)
{
    const size_t n_source = flow->energy->n_table - 1;
    for (size_t s = 0; s < n_source; s++) {
        const struct rmap_energy_table *table = &flow->energy->table[1 + s];
        const size_t from = s < flow->n_source ? s : flow->n_source - 1;
        for (size_t i = 0; i < table->n_row; i++) {
            const struct rmap_energy_row *row = &table->row[i];
            if (row->end == RMAP_ENERGY_HEAT &&
                !(flow->energy->table[0].row[flow->energy->table[0].n_row - 1].rays > 0.0))
                continue; /* photons that gained: no flow away from them */
            size_t end = row->end == RMAP_ENERGY_OBJECT ? flow->end_of_object[row->index]
                         : row->end == RMAP_ENERGY_MEDIUM
                             ? flow->end_of_medium[row->index]
                             : flow->end_of_other[row->end - RMAP_ENERGY_LEFT];
            flow->end[end].from[from] += row->flux;
            flow->end[end].sum += row->flux;
        }
    }
}

static size_t add_node(const struct flow *flow, const char *name, const char *colour, int column,
                       double value)
{
    struct rmap_sankey *sankey = flow->sankey;
    struct rmap_sankey_node *node = &sankey->node[sankey->n_node];
    *node = (struct rmap_sankey_node){.colour = colour, .column = column, .value = value};
    char flux[32];
    (void)snprintf(flux, sizeof flux, value >= 100.0 && value < 1e6 ? "%.0f" : "%.3g", value);
    (void)snprintf(node->label, sizeof node->label, "%s: %s %s, %.3g %%", name, flux,
                   flow->energy->unit, 100.0 * value / flow->energy->table[0].flux);
    return sankey->n_node++;
}

static void add_sources(const struct flow *flow)
{
    const size_t n = flow->energy->n_table - 1;
    for (size_t s = 0; s < flow->n_source; s++) {
        char name[128];
        double flux = flow->energy->table[1 + s].flux;
        shorten(flow->energy->table[1 + s].source, NAME_MAX_CHARACTERS, name, sizeof name);
        if (s + 1 == flow->n_source && n > flow->n_source) {
            (void)snprintf(name, sizeof name, "%zu other sources", n - s);
            for (size_t k = s + 1; k < n; k++)
                flux += flow->energy->table[1 + k].flux;
        }
        (void)add_node(flow, name, source_ink[s], 0, flux);
    }
}

static void link_nodes(const struct flow *flow, size_t from, size_t to, double value,
                       const char *colour)
{
    (void)rmap_sankey_link_add(flow->sankey, &(struct rmap_sankey_link){from, to, value, colour});
}

/* One box in the middle for a group, or a band's passage for an end without one; then what flows
 * into and out of it. Ends [first, last) are those of the group, or the one end. */
static void add_middle(const struct flow *flow, size_t first, size_t last, const size_t *end_node)
{
    const struct flow_end *end = &flow->end[first];
    const bool single = flow->n_source == 1;
    const char *name =
        end->group == NO_GROUP ? "" : flow->scene->group[flow->group[end->group]].name;
    double from[SOURCE_MAX + 1] = {0.0}, sum = 0.0;
    for (size_t e = first; e < last; e++) {
        sum += flow->end[e].sum;
        for (size_t s = 0; s < flow->n_source; s++)
            from[s] += flow->end[e].from[s];
    }
    char text[128];
    shorten(name, NAME_MAX_CHARACTERS, text, sizeof text);
    const size_t node = add_node(flow, text, end->colour, 1, sum);
    flow->sankey->node[node].passing = end->group == NO_GROUP;
    for (size_t s = 0; s < flow->n_source; s++)
        link_nodes(flow, s, node, from[s], single ? end->colour : source_ink[s]);
    for (size_t e = first; e < last; e++) {
        if (end->group != NO_GROUP)
            link_nodes(flow, node, end_node[e], flow->end[e].sum, flow->end[e].colour);
        for (size_t s = 0; s < flow->n_source && end->group == NO_GROUP; s++)
            link_nodes(flow, node, end_node[e], flow->end[e].from[s],
                       single ? end->colour : source_ink[s]);
    }
}

static void make_nodes(const struct flow *flow)
{
    size_t end_node[END_MAX];
    struct rmap_sankey *sankey = flow->sankey;
    sankey->n_column = flow->n_group > 0 ? 3 : 2;
    add_sources(flow);
    for (size_t e = 0; e < flow->n_end; e++)
        end_node[e] = add_node(flow, flow->end[e].name, flow->end[e].colour, sankey->n_column - 1,
                               flow->end[e].sum);
    if (flow->n_group == 0)
        for (size_t s = 0; s < flow->n_source; s++)
            for (size_t e = 0; e < flow->n_end; e++)
                link_nodes(flow, s, end_node[e], flow->end[e].from[s],
                           flow->n_source == 1 ? flow->end[e].colour : source_ink[s]);
    for (size_t e = 0; e < flow->n_end && flow->n_group > 0;) {
        size_t last = e + 1;
        while (last < flow->n_end && flow->end[e].group != NO_GROUP &&
               flow->end[last].group == flow->end[e].group)
            last++;
        add_middle(flow, e, last, end_node);
        e = last;
    }
}

enum rmap_status rmap_energy_flow(const struct rmap_energy *energy, struct rmap_sankey *sankey,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = energy->scene;
    struct flow *flow = rmap_alloc(1, sizeof *flow);
    if (!flow)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    *flow = (struct flow){.energy = energy, .scene = scene, .sankey = sankey};
    flow->n_source = energy->n_table - 1 < SOURCE_MAX ? energy->n_table - 1 : SOURCE_MAX;
    flow->group_flux = rmap_alloc(scene->n_group + 1, sizeof *flow->group_flux);
    flow->end_of_object = rmap_alloc(scene->n_object + 1, sizeof *flow->end_of_object);
    flow->end_of_medium = rmap_alloc(scene->n_medium + 1, sizeof *flow->end_of_medium);
    if (!flow->group_flux || !flow->end_of_object || !flow->end_of_medium)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture"));
    choose_groups(flow);
    for (size_t g = 0; g < flow->n_group; g++)
        add_objects(flow, g);
    add_objects(flow, NO_GROUP);
    add_media(flow);
    add_others(flow);
    add_flows(flow);
    make_nodes(flow);
out:
    rmap_free(flow->end_of_medium);
    rmap_free(flow->end_of_object);
    rmap_free(flow->group_flux);
    rmap_free(flow);
    return st;
}
