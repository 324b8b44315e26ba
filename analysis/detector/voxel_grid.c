/* SPDX-License-Identifier: MIT
 *
 * A box along the world's axes, cut into equal voxels, and the parts of straight ways in each.
 */
#include "analysis/detector/voxel_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/unit.h"
#include "scene/bounds.h"

static void coordinates(struct rmap_vec3 p, double x[3])
{
    x[0] = p.x;
    x[1] = p.y;
    x[2] = p.z;
}

static enum rmap_status read_cells(const char *text, struct rmap_voxel_grid *grid,
                                   struct rmap_error *err)
{
    unsigned long n[3] = {0, 0, 0};
    const char *c = text;
    char *end = NULL;
    int k = 0;
    for (; k < 3; k++, c = end + 1) {
        n[k] = *c >= '0' && *c <= '9' ? strtoul(c, &end, 10) : 0;
        if (n[k] == 0 || n[k] > RMAP_VOXELS_MAX || *end != 'x')
            break;
    }
    const bool whole = k < 3 && end && *end == 0 && (k == 0 || k == 2);
    if (k == 0)
        n[1] = n[2] = n[0];
    if (!whole || n[0] == 0 || n[1] == 0 || n[2] == 0)
        return rmap_error_set(err, RMAP_USAGE, "--cells '%.40s': say NXxNYxNZ, as 40x40x80, or 50",
                              text);
    if ((double)n[0] * (double)n[1] * (double)n[2] > RMAP_VOXELS_MAX)
        return rmap_error_set(err, RMAP_USAGE, "%lu x %lu x %lu voxels are too many: %u at most",
                              n[0], n[1], n[2], RMAP_VOXELS_MAX);
    for (k = 0; k < 3; k++)
        grid->n[k] = (uint32_t)n[k];
    return RMAP_OK;
}

static enum rmap_status read_region(const struct rmap_scene *scene, const char *text,
                                    struct rmap_voxel_grid *grid, struct rmap_error *err)
{
    double x[6];
    const char *c = text;
    int k = 0;
    for (; k < 6; k++) {
        char *end = NULL;
        x[k] = strtod(c, &end);
        if (end == c || !isfinite(x[k]) || (k < 5 && *end != ','))
            break;
        c = end + (k < 5);
    }
    c += strspn(c, " ");
    const struct rmap_written_unit *unit =
        k == 6 && *c ? rmap_unit_of_scene(c, RMAP_DIMENSION_LENGTH) : NULL;
    if (k < 6 || (*c && !unit))
        return rmap_error_set(err, RMAP_USAGE,
                              "--region '%.80s': give six numbers, a unit of length behind them if "
                              "wanted, x0,y0,z0,x1,y1,z1, as -1,-1,0,1,1,5 cm",
                              text);
    for (k = 0; k < 3; k++) {
        const double size = unit ? unit->size / scene->unit_m : 1.0;
        grid->low[k] = size * x[k];
        grid->high[k] = size * x[k + 3];
        if (!(grid->high[k] > grid->low[k]))
            return rmap_error_set(err, RMAP_USAGE, "--region '%.80s' has no extent in %c", text,
                                  "xyz"[k]);
    }
    return RMAP_OK;
}

static enum rmap_status cover_scene(const struct rmap_scene *scene, struct rmap_voxel_grid *grid,
                                    struct rmap_error *err)
{
    struct rmap_bounds box = rmap_bounds_empty();
    for (size_t o = 0; o < scene->n_object; o++)
        rmap_bounds_include_geometry(&box, &scene->geometry[scene->object[o].geometry],
                                     &scene->object[o].to_world);
    coordinates(box.lower, grid->low);
    coordinates(box.upper, grid->high);
    for (int k = 0; k < 3; k++)
        if (box.infinite || !(grid->high[k] > grid->low[k]))
            return rmap_error_set(err, RMAP_USAGE,
                                  "the scene's objects have no extent in %c: say where the voxels "
                                  "are to be, with --region x0,y0,z0,x1,y1,z1",
                                  "xyz"[k]);
    return RMAP_OK;
}

enum rmap_status rmap_voxel_grid_read(const struct rmap_scene *scene, const char *cells,
                                      const char *region, struct rmap_voxel_grid *grid,
                                      struct rmap_error *err)
{
    *grid = (struct rmap_voxel_grid){.diagonal = 0.0};
    enum rmap_status st = read_cells(cells, grid, err);
    if (st == RMAP_OK)
        st = region ? read_region(scene, region, grid, err) : cover_scene(scene, grid, err);
    if (st != RMAP_OK)
        return st;
    for (int k = 0; k < 3; k++)
        grid->step[k] = (grid->high[k] - grid->low[k]) / grid->n[k];
    grid->diagonal = rmap_length(rmap_vec3(grid->step[0], grid->step[1], grid->step[2]));
    return RMAP_OK;
}

size_t rmap_voxel_grid_n(const struct rmap_voxel_grid *grid)
{
    return (size_t)grid->n[0] * grid->n[1] * grid->n[2];
}

static size_t index_of(const struct rmap_voxel_grid *grid, const int64_t cell[3])
{
    return (size_t)cell[0] + grid->n[0] * ((size_t)cell[1] + grid->n[1] * (size_t)cell[2]);
}

static int64_t clamped(double x, uint32_t n)
{
    return (int64_t)fmin(fmax(floor(x), 0.0), n - 1.0);
}

size_t rmap_voxel_grid_cell(const struct rmap_voxel_grid *grid, struct rmap_vec3 p)
{
    double x[3];
    int64_t cell[3];
    coordinates(p, x);
    for (int k = 0; k < 3; k++) {
        if (!(x[k] >= grid->low[k] && x[k] <= grid->high[k]))
            return SIZE_MAX;
        cell[k] = clamped((x[k] - grid->low[k]) / grid->step[k], grid->n[k]);
    }
    return index_of(grid, cell);
}

/* A way through the grid: from a, in steps of voxels; t goes from 0 to 1. */
struct way {
    double a[3], d[3], t, end;
    int64_t cell[3];
};

/* Cut to the box, and the voxel it begins in. False: it passes beside. */
static bool enter(const struct rmap_voxel_grid *grid, struct way *way)
{
    way->t = 0.0;
    way->end = 1.0;
    for (int k = 0; k < 3; k++) {
        const double n = grid->n[k];
        if (!(way->d[k] > 0.0 || way->d[k] < 0.0)) {
            if (!(way->a[k] >= 0.0 && way->a[k] <= n))
                return false;
            continue;
        }
        const double one = -way->a[k] / way->d[k], other = (n - way->a[k]) / way->d[k];
        way->t = fmax(way->t, fmin(one, other));
        way->end = fmin(way->end, fmax(one, other));
    }
    for (int k = 0; k < 3; k++) {
        const double x = way->a[k] + way->t * way->d[k];
        way->cell[k] = clamped(way->d[k] < 0.0 ? ceil(x) - 1.0 : x, grid->n[k]);
    }
    return way->t < way->end;
}

/* Where the way leaves its voxel, and through which axis' face. */
static double leave(const struct way *way, int *axis)
{
    double least = (double)INFINITY;
    for (int k = 0; k < 3; k++) {
        if (!(way->d[k] > 0.0 || way->d[k] < 0.0))
            continue;
        const double face = (double)(way->cell[k] + (way->d[k] > 0.0));
        const double t = (face - way->a[k]) / way->d[k];
        if (t < least) {
            least = t;
            *axis = k;
        }
    }
    return least;
}

void rmap_voxel_grid_walk(const struct rmap_voxel_grid *grid, struct rmap_vec3 from,
                          struct rmap_vec3 to, double weight, struct rmap_cell_sums *sums)
{
    struct way way;
    double a[3], b[3];
    const double units = weight * rmap_length(rmap_sub(to, from)) / grid->diagonal;
    coordinates(from, a);
    coordinates(to, b);
    for (int k = 0; k < 3; k++) {
        way.a[k] = (a[k] - grid->low[k]) / grid->step[k];
        way.d[k] = (b[k] - a[k]) / grid->step[k];
    }
    if (!(units > 0.0) || !enter(grid, &way))
        return;
    for (;;) {
        int axis = 0;
        const double t = fmin(leave(&way, &axis), way.end);
        if (t > way.t) {
            rmap_cell_sums_add(sums, index_of(grid, way.cell), (t - way.t) * units);
            way.t = t;
        }
        way.cell[axis] += way.d[axis] > 0.0 ? 1 : -1;
        if (!(t < way.end) || way.cell[axis] < 0 || way.cell[axis] >= grid->n[axis])
            return;
    }
}

double rmap_voxel_grid_reach(const struct rmap_voxel_grid *grid, struct rmap_vec3 p)
{
    double x[3], square = 0.0;
    coordinates(p, x);
    for (int k = 0; k < 3; k++) {
        const double most = fmax(fabs(grid->low[k] - x[k]), fabs(grid->high[k] - x[k]));
        square += most * most;
    }
    return sqrt(square);
}
