/* SPDX-License-Identifier: MIT
 *
 * Fields from shared objects (gradient/raymap_field.h).
 */
#include "gradient/field_plugin.h"

#include <dlfcn.h>
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_internal.h"

struct plugin {
    struct rmap_field field;
    void *library;
    const struct raymap_field *of;
    void *state;
};

/* An index as the plug-in gives it; rubbish is no index. */
static bool index_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                     double gradient[3])
{
    const struct plugin *plugin = (const struct plugin *)field;
    const double place[3] = {p.x, p.y, p.z};
    *n = 0;
    gradient[0] = gradient[1] = gradient[2] = 0;
    return plugin->of->at(plugin->state, (size_t)channel, place, n, gradient) == 0 && isfinite(*n);
}

static bool value_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n)
{
    double unused[3];
    return index_at(field, channel, p, n, unused);
}

static bool at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
               struct rmap_vec3 *gradient)
{
    double slope[3];
    if (((const struct plugin *)field)->of->flags & RAYMAP_FIELD_NO_GRADIENT)
        return rmap_field_differences(field, value_at, channel, p, n, gradient);
    if (!index_at(field, channel, p, n, slope))
        return false;
    *gradient = rmap_vec3(slope[0], slope[1], slope[2]);
    return isfinite(slope[0] + slope[1] + slope[2]);
}

static double best_step(const struct rmap_field *field, struct rmap_vec3 p,
                        struct rmap_vec3 direction)
{
    const struct plugin *plugin = (const struct plugin *)field;
    const double place[3] = {p.x, p.y, p.z}, towards[3] = {direction.x, direction.y, direction.z};
    double step =
        plugin->of->best_step ? plugin->of->best_step(plugin->state, place, towards) : 0.0;
    return step > 0 ? step : (double)INFINITY;
}

static void destroy(struct rmap_field *field)
{
    struct plugin *plugin = (struct plugin *)field;
    if (plugin->of && plugin->of->destroy)
        plugin->of->destroy(plugin->state);
    if (plugin->library)
        (void)dlclose(plugin->library);
    rmap_free(plugin);
}

static const struct rmap_field_ops ops = {
    .model = "plugin", .at = at, .best_step = best_step, .destroy = destroy};

/* ---- loading ---- */

static enum rmap_status find_description(const char *path, void *library,
                                         const struct raymap_field **of, struct rmap_error *err)
{
    const struct raymap_field *(*describe)(void) = NULL;
    void *symbol = dlsym(library, "raymap_field");
    /* POSIX's way from an object pointer to a function pointer. */
    memcpy(&describe, &symbol, sizeof describe);
    if (!describe)
        return rmap_error_set(err, RMAP_INPUT,
                              "'%s' is no plug-in for gradient media: it has no function "
                              "'raymap_field' (see raymap_field.h)",
                              path);
    *of = describe();
    if (*of && (*of)->abi == RAYMAP_FIELD_ABI && (*of)->nbytes >= sizeof **of && (*of)->at)
        return RMAP_OK;
    if (*of && (*of)->abi != RAYMAP_FIELD_ABI)
        return rmap_error_set(err, RMAP_INPUT,
                              "plug-in '%s' is of version %u of the interface, this program of %d: "
                              "build it against this program's raymap_field.h",
                              path, (unsigned)(*of)->abi, RAYMAP_FIELD_ABI);
    *of = NULL;
    return rmap_error_set(err, RMAP_INPUT,
                          "plug-in '%s' describes no field: 'at' or 'nbytes' is wrong", path);
}

static enum rmap_status create_state(struct plugin *plugin, const struct raymap_field *of,
                                     const char *path, const struct raymap_field_setup *setup,
                                     struct rmap_error *err)
{
    char text[256] = "";
    void *state = NULL;
    int refused = of->create ? of->create(setup, &state, text, sizeof text) : 0;
    text[sizeof text - 1] = 0;
    if (refused)
        return rmap_error_set(err, RMAP_INPUT, "plug-in '%s' refuses its parameters: %s", path,
                              text[0] ? text : "it does not say why");
    plugin->of = of;
    plugin->state = state;
    return RMAP_OK;
}

enum rmap_status rmap_field_plugin(struct rmap_field **field_ret, const char *path,
                                   const struct raymap_field_setup *setup, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct raymap_field *of = NULL;
    struct plugin *plugin =
        (struct plugin *)rmap_field_new(sizeof *plugin, &ops, (int)setup->n_channel, err);
    if (!plugin)
        return RMAP_SYSTEM;
    plugin->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!plugin->library) {
        const char *why = dlerror();
        st = rmap_error_set(err, RMAP_INPUT, "plug-in '%s' cannot be loaded: %s", path,
                            why ? why : "unknown");
        goto out;
    }
    RMAP_TRY(find_description(path, plugin->library, &of, err));
    RMAP_TRY(create_state(plugin, of, path, setup, err));
    if (!(of->flags & RAYMAP_FIELD_DISPERSIVE))
        plugin->field.n_channel = 1;
    plugin->field.step = 6e-6 * setup->size; /* eps^(1/3): rounding and cubic term alike */
    plugin->field.may_be_missing = true;
    *field_ret = &plugin->field;
    plugin = NULL;
out:
    if (plugin)
        destroy(&plugin->field);
    return st;
}

/* ---- absent ---- */

static bool nowhere(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                    struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    (void)p;
    (void)n;
    (void)gradient;
    return false;
}

static const struct rmap_field_ops absent_ops = {.model = "plugin that is not loaded",
                                                 .at = nowhere};

enum rmap_status rmap_field_absent(struct rmap_field **field_ret, int n_channel,
                                   struct rmap_error *err)
{
    struct rmap_field *field = rmap_field_new(sizeof *field, &absent_ops, n_channel, err);
    if (!field)
        return RMAP_SYSTEM;
    field->may_be_missing = true;
    *field_ret = field;
    return RMAP_OK;
}
