/* SPDX-License-Identifier: MIT
 *
 * A tree that follows a change of its text.
 */
#include "io/scene/yaml_follow.h"

#include "io/scene/yaml_span.h"

/* Columns behind a place in its line. */
static void shift(struct rmap_yaml_node *node, int line, int column, int by)
{
    if (node->line == line && node->column > column)
        node->column += by;
    for (size_t i = 0; i < node->n_item; i++) {
        struct rmap_yaml_item *item = &node->item[i];
        if (item->line == line && item->column > column)
            item->column += by;
        shift(item->value, line, column, by);
    }
}

static void put_at(struct rmap_yaml_node *node, int line, int column)
{
    node->line = line;
    node->column += column - 1;
    for (size_t i = 0; i < node->n_item; i++) {
        node->item[i].line = line;
        node->item[i].column += column - 1;
        put_at(node->item[i].value, line, column);
    }
}

static int count_characters(const char *text, size_t nbytes)
{
    int n = 0;
    for (size_t i = 0; i < nbytes; i++)
        n += (text[i] & 0xC0) != 0x80;
    return n;
}

static bool breaks_line(const char *text, size_t nbytes)
{
    bool breaks = false;
    for (size_t i = 0; i < nbytes && !breaks; i++)
        breaks = rmap_yaml_line_break(text + i) > 0;
    return breaks;
}

bool rmap_yaml_follow(struct rmap_yaml_node *root, struct rmap_yaml_node *node, const char *from,
                      size_t from_nbytes, const char *to, size_t to_nbytes)
{
    const int line = node->line, column = node->column;
    struct rmap_yaml_node *value = NULL, *copy = NULL;
    struct rmap_diagnostics found;
    rmap_diagnostics_init(&found, "value");
    const bool can = from_nbytes > 0 && !breaks_line(from, from_nbytes) &&
                     !breaks_line(to, to_nbytes) &&
                     rmap_yaml_parse(to, to_nbytes, &value, &found, NULL) == RMAP_OK &&
                     rmap_yaml_copy(root, value, &copy, NULL) == RMAP_OK;
    if (can) {
        shift(root, line, column,
              count_characters(to, to_nbytes) - count_characters(from, from_nbytes));
        put_at(copy, line, column);
        *node = *copy;
    }
    rmap_yaml_destroy(value);
    rmap_diagnostics_fini(&found);
    return can;
}
