/* SPDX-License-Identifier: MIT
 *
 * Values of the keys of gradient media: numbers on the channels, alone, in structures, in lists.
 */
#include <math.h>
#include <string.h>

#include "io/scene/scene_field.h"
#include "optics/spectrum.h"

void rmap_reader_channel_values(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                const char *what, const struct rmap_range *range, double *value,
                                bool *good)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    double *column[2], number = 0;
    size_t n = 0;
    if (node->kind != RMAP_YAML_MAP) {
        *good = rmap_reader_scalar(reader, node, what, range, &number);
        for (int c = 0; *good && c < channels->n; c++)
            value[c] = number;
        return;
    }
    rmap_reader_table(reader, node, "wavelength value", 2, range, &n, column);
    *good = n > 0;
    const struct rmap_table1 table = {n, column[0], column[1]};
    for (int c = 0; *good && c < channels->n; c++)
        value[c] = rmap_table1_at(&table, channels->wavelength_nm[c]);
}

void rmap_reader_parameters(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_field_parameter *parameter, size_t width,
                            double *value, bool *good)
{
    const int n = reader->scene->channels.n;
    *good = true;
    for (size_t k = 0; k < width; k++) {
        const struct rmap_yaml_node *at = rmap_yaml_get(node, parameter[k].name);
        double on_channel[RMAP_CHANNEL_MAX];
        char what[80];
        bool fine = true;
        (void)snprintf(what, sizeof what, "'%s'", parameter[k].name);
        for (int c = 0; c < n; c++)
            on_channel[c] = parameter[k].otherwise;
        if (at)
            rmap_reader_channel_values(reader, at, what, &rmap_range_any, on_channel, &fine);
        else if (isnan(parameter[k].otherwise)) {
            rmap_reader_error(reader, node, "'%s' is missing: add it", parameter[k].name);
            fine = false;
        }
        *good &= fine;
        for (int c = 0; fine && c < n; c++)
            value[(size_t)c * width + k] = on_channel[c];
    }
}

void rmap_reader_channel_list(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, size_t n_max, size_t *width_ret, double **value_ret)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(map, key);
    const size_t n = (size_t)reader->scene->channels.n;
    char what[80];
    bool good = true;
    (void)snprintf(what, sizeof what, "'%s'", key);
    *value_ret = NULL;
    if (!list || list->kind != RMAP_YAML_LIST || !list->n_item || list->n_item > n_max) {
        rmap_reader_error(reader, list ? list : map, "%s must be a list of 1 to %zu numbers", what,
                          n_max);
        return;
    }
    double *value = rmap_reader_alloc(reader, list->n_item * n, sizeof *value);
    if (!value)
        return;
    for (size_t k = 0; k < list->n_item; k++) {
        double on_channel[RMAP_CHANNEL_MAX] = {0};
        bool fine = true;
        rmap_reader_channel_values(reader, list->item[k].value, what, &rmap_range_any, on_channel,
                                   &fine);
        good &= fine;
        for (size_t c = 0; c < n; c++)
            value[c * list->n_item + k] = on_channel[c];
    }
    *width_ret = list->n_item;
    *value_ret = good ? value : NULL;
}

int rmap_reader_distinct(const struct rmap_reader *reader, const double *value, size_t width)
{
    const int n = reader->scene->channels.n;
    for (int c = 1; c < n; c++)
        if (memcmp(value + (size_t)c * width, value, width * sizeof *value) != 0)
            return n;
    return 1;
}

int rmap_reader_distinct_wavelengths(const struct rmap_reader *reader)
{
    return rmap_reader_distinct(reader, reader->scene->channels.wavelength_nm, 1);
}
