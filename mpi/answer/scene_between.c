/* SPDX-License-Identifier: MIT
 *
 * A scene once more, in light of wavelengths between its own.
 */
#include "mpi/answer/scene_between.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

/* As it is written: "spectrum.wavelengths=[400, 401.5, ...]" */
enum { NUMBER_NBYTES = 28, LIST_NBYTES = 40 + RMAP_CHANNEL_MAX * NUMBER_NBYTES };

/* So many equal parts of each gap of n wavelengths, at least 2, that all are channels. */
static int parts_of(int n)
{
    return (RMAP_CHANNEL_MAX - 1) / (n - 1);
}

static void write_list(const double *nm, int n, char *list)
{
    const int parts = parts_of(n);
    size_t at = (size_t)snprintf(list, LIST_NBYTES, "spectrum.wavelengths=[%.17g", nm[0]);
    for (int i = 1; i < n; i++)
        for (int k = 1; k <= parts; k++) {
            const double next =
                k < parts ? nm[i - 1] + (nm[i] - nm[i - 1]) * k / (double)parts : nm[i];
            at += (size_t)snprintf(list + at, LIST_NBYTES - at, ", %.17g", next);
        }
    (void)snprintf(list + at, LIST_NBYTES - at, "]");
}

/* With one more --set; NULL: it is no scene so, or with more warnings. */
static struct rmap_scene *read_at(const struct rmap_bundle *bundle, const char *surface, char *list,
                                  size_t n_warning)
{
    struct rmap_bundle with = *bundle; /* complete: nothing is added to it */
    struct rmap_scene_options *options = &with.options;
    struct rmap_scene *scene = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_error err;
    const size_t n = options->n_set;
    char **set = rmap_alloc(n + 1, sizeof *set);
    if (!set)
        return NULL;
    if (n > 0)
        memcpy(set, options->set, n * sizeof *set);
    set[n] = list;
    options->set = set;
    options->n_set = n + 1;
    options->surface = surface;
    rmap_diagnostics_init(&diagnostics, bundle->path);
    if (rmap_scene_read(&with, &scene, &diagnostics, &err) == RMAP_OK &&
        diagnostics.n + diagnostics.n_dropped > n_warning) {
        rmap_scene_destroy(scene);
        scene = NULL;
    }
    rmap_diagnostics_fini(&diagnostics);
    rmap_free(set);
    return scene;
}

/* On either side of the one wavelength, where data cover it. */
static struct rmap_scene *read_around(const struct rmap_bundle *bundle, const char *surface,
                                      double nm, size_t n_warning)
{
    static const double part[] = {0.3, 0.1};
    char list[LIST_NBYTES];
    struct rmap_scene *scene = NULL;
    for (size_t k = 0; k < sizeof part / sizeof *part && !scene; k++) {
        write_list((const double[]){nm * (1.0 - part[k]), nm, nm * (1.0 + part[k])}, 3, list);
        scene = read_at(bundle, surface, list, n_warning);
    }
    return scene;
}

struct rmap_scene *rmap_scene_between(const struct rmap_bundle *bundle,
                                      const struct rmap_scene *scene, const char *surface,
                                      size_t n_warning)
{
    const struct rmap_channels *channels = &scene->channels;
    char list[LIST_NBYTES];
    if (channels->mode != RMAP_COLOUR_SPECTRAL || !bundle->meshes_complete)
        return NULL;
    if (channels->n == 1)
        return read_around(bundle, surface, channels->wavelength_nm[0], n_warning);
    if (parts_of(channels->n) < 2)
        return NULL;
    write_list(channels->wavelength_nm, channels->n, list);
    return read_at(bundle, surface, list, n_warning);
}
