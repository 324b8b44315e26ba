/* SPDX-License-Identifier: MIT
 *
 * Tables of rays, segments and registrations, a row for each, in plain columns of numbers: those of
 * a map, and what follows from them, by the names and in the units that Python's `records` gives
 * them. Vectors come by their parts ("position_x", "cell_i", "colour_0"), or whole ("position").
 */
#ifndef RMAP_RAY_TABLE_H
#define RMAP_RAY_TABLE_H

#include "io/map/map_reader.h"
#include "portion/portion.h"

/* A ray: row `row` of a portion of colour space `space` that has all columns; its rows of the other
 * tables begin at `segment` and `registration`. */
struct rmap_table_ray {
    const struct rmap_portion *portion;
    size_t space, row, segment, registration;
};

struct rmap_ray_report;
struct rmap_table_quantity;

struct rmap_table_column {
    enum rmap_table table;
    char name[40];
    enum rmap_element element;
    int width;        /* elements per row; 0: as many as the portion has channels */
    const char *unit; /* "mm", "1" */
    const char *description;
    /* A column of a map, of this table or, of the row's ray, of /ray; or a quantity. */
    enum rmap_column column; /* RMAP_COLUMN_COUNT: a quantity */
    int part;
    const struct rmap_table_quantity *quantity;
};

struct rmap_ray_table {
    const struct rmap_map *map; /* borrowed */
    size_t n;
    struct rmap_table_column *column; /* [n], table by table */
    bool is_reported;                 /* a quantity among them needs the ray's report */
    rmap_column_set columns;          /* that reading them needs */
};

enum rmap_vectors {
    RMAP_VECTORS_BY_PARTS, /* tables of rays, segments and registrations */
    RMAP_VECTORS_WHOLE     /* and, where the map has them, of points of curved segments */
};

/* names: "registration/x, registration/time, ray", a table standing for all of its columns; NULL:
 * all tables. RMAP_INPUT, with the nearest name. */
enum rmap_status rmap_ray_table_create(const struct rmap_map *map, const char *names,
                                       enum rmap_vectors vectors, struct rmap_ray_table **table_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_table_destroy(struct rmap_ray_table *table); /* NULL is fine */

/* "ray", "segment", "registration", "curve". */
const char *rmap_ray_table_word(enum rmap_table table);

/* Rows that a ray has in a table, other than of curves. */
size_t rmap_ray_table_rows(const struct rmap_table_ray *ray, enum rmap_table table);

/* Row k of a ray's rows of a column, as the column's elements, to `out`. report: the ray's, where
 * the table is_reported. Not of curves. */
void rmap_ray_table_read(const struct rmap_ray_table *table, const struct rmap_table_column *column,
                         const struct rmap_table_ray *ray, const struct rmap_ray_report *report,
                         size_t k, void *out);

#endif
