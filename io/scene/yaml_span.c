/* SPDX-License-Identifier: MIT
 *
 * The tree knows where a node begins; libyaml's events say where it ends.
 */
#include "io/scene/yaml_span.h"

#include <string.h>
#include <yaml.h>

static bool is_flow(const yaml_event_t *event)
{
    return (event->type == YAML_SEQUENCE_START_EVENT &&
            event->data.sequence_start.style == YAML_FLOW_SEQUENCE_STYLE) ||
           (event->type == YAML_MAPPING_START_EVENT &&
            event->data.mapping_start.style == YAML_FLOW_MAPPING_STYLE);
}

static bool begins(const yaml_event_t *event)
{
    return event->type == YAML_SEQUENCE_START_EVENT || event->type == YAML_MAPPING_START_EVENT;
}

static bool ends(const yaml_event_t *event)
{
    return event->type == YAML_SEQUENCE_END_EVENT || event->type == YAML_MAPPING_END_EVENT;
}

/* So many characters further. */
static size_t skip(const char *text, size_t at, size_t character)
{
    for (; character > 0 && text[at]; character--)
        for (at++; (text[at] & 0xC0) == 0x80;)
            at++;
    return at;
}

/* libyaml counts characters, from where it begins; texts are bytes. */
static void count_bytes(const char *text, size_t from, struct rmap_yaml_span *span)
{
    const struct rmap_yaml_span in = *span;
    const size_t mark = strncmp(text + from, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    span->before = skip(text, from + mark, in.before);
    span->first = skip(text, span->before, in.first - in.before);
    span->end = skip(text, span->first, in.end - in.first);
}

static bool is_block_scalar(const yaml_event_t *event)
{
    return event->type == YAML_SCALAR_EVENT &&
           (event->data.scalar.style == YAML_LITERAL_SCALAR_STYLE ||
            event->data.scalar.style == YAML_FOLDED_SCALAR_STYLE);
}

/* libyaml's end of a block scalar is where the line behind it begins. */
static void end_before_break(const char *text, struct rmap_yaml_span *span)
{
    for (size_t n = 3; n > 0; n--)
        if (span->end >= span->first + n && rmap_yaml_line_break(text + span->end - n) == n) {
            span->end -= n;
            return;
        }
}

/* Reads from a byte, which begins a line, on; `line` counts from there. Of a block, libyaml's end
 * is where the next thing begins: its own is that of the last thing in it. */
static bool span_from(const char *text, size_t from, int line, int column, bool is_scalar,
                      int n_node, struct rmap_yaml_span *span)
{
    yaml_parser_t parser;
    yaml_event_t event;
    int depth = 0, inside = -1, flow = -1; /* depths at which it, and what is in brackets, begins */
    size_t last = 0;
    bool over = false, block = false;
    if (!yaml_parser_initialize(&parser))
        return false;
    yaml_parser_set_input_string(&parser, (const unsigned char *)text + from, strlen(text + from));
    while (n_node > 0 && !over && yaml_parser_parse(&parser, &event)) {
        const yaml_mark_t at = event.start_mark, end = event.end_mark;
        const bool content = event.type == YAML_SCALAR_EVENT || event.type == YAML_ALIAS_EVENT;
        depth -= ends(&event);
        if (inside < 0 && (content || begins(&event)) && (int)at.line + 1 == line &&
            (int)at.column + 1 == column &&
            (event.type == YAML_ALIAS_EVENT || begins(&event) != is_scalar)) {
            *span = (struct rmap_yaml_span){at.index,        end.index, last,     (int)at.column,
                                            is_flow(&event), true,      flow >= 0};
            inside = depth;
            block = is_block_scalar(&event);
        } else if (inside >= 0 && (content || (ends(&event) && end.index > at.index))) {
            span->empty = span->empty && ends(&event);
            span->end = end.index;
            block = is_block_scalar(&event);
        }
        if (content || end.index > at.index) /* brackets, too */
            last = end.index;
        n_node -= inside == depth && (content || ends(&event));
        if (is_flow(&event) && flow < 0)
            flow = depth;
        else if (ends(&event) && flow == depth)
            flow = -1;
        depth += begins(&event);
        over = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    if (n_node == 0)
        count_bytes(text, from, span);
    if (n_node == 0 && block)
        end_before_break(text, span);
    return n_node == 0;
}

size_t rmap_yaml_line_break(const char *text)
{
    if (text[0] == '\r' && text[1] == '\n')
        return 2;
    if (text[0] == '\n' || text[0] == '\r')
        return 1;
    if (strncmp(text, "\xC2\x85", 2) == 0)
        return 2;
    return strncmp(text, "\xE2\x80\xA8", 3) == 0 || strncmp(text, "\xE2\x80\xA9", 3) == 0 ? 3 : 0;
}

/* The byte at which a line, n further than that of `from`, begins. */
static size_t line_start(const char *text, size_t from, int n)
{
    while (n > 0 && text[from]) {
        const size_t end = from + strcspn(text + from, "\n\r\xC2\xE2"),
                     nbytes = rmap_yaml_line_break(text + end);
        n -= nbytes > 0;
        from = end + (nbytes > 0 ? nbytes : text[end] != 0);
    }
    return from;
}

/* Only blanks stand before that column, and the dash of a list's item. */
static bool begins_line(const char *text, int column, bool is_item)
{
    int n_dash = 0;
    for (int i = 0; i + 1 < column; i++) {
        n_dash += text[i] == '-';
        if (text[i] != ' ' && text[i] != '-')
            return false;
    }
    return n_dash == is_item;
}

/* Neither in brackets nor behind an anchor or a tag. `from`: where the line `first` begins. */
static bool is_block(const char *text, size_t from, int first, const struct rmap_yaml_node *node)
{
    if (node->n_item == 0 || node->line < first)
        return false;
    if (node->kind == RMAP_YAML_MAP)
        return node->line == node->item[0].line && node->column == node->item[0].column;
    return text[skip(text, line_start(text, from, node->line - first), (size_t)node->column - 1)] ==
           '-';
}

/* Where reading can begin for what stands in a line: the innermost entry of blocks around it that
 * begins a line. What stands before that says nothing of it, and may be long. */
static size_t begin_of(const char *text, const struct rmap_yaml_node *root, int line, int *first)
{
    size_t from = 0;
    *first = 1;
    for (const struct rmap_yaml_node *node = root; is_block(text, from, *first, node);) {
        const struct rmap_yaml_item *around = NULL;
        for (size_t i = 0; i < node->n_item; i++)
            if (node->item[i].line <= line && (!around || node->item[i].line > around->line))
                around = &node->item[i];
        if (!around || around->line < *first)
            break;
        const size_t at = line_start(text, from, around->line - *first);
        if (begins_line(text + at, around->column, !around->key)) {
            from = at;
            *first = around->line;
        }
        node = around->value;
    }
    return from;
}

bool rmap_yaml_span(const char *text, const struct rmap_yaml_node *root, int line, int column,
                    bool is_scalar, int n_node, struct rmap_yaml_span *span)
{
    int first = 1;
    /* Keys that are merged of an anchor's mapping stand in its lines. */
    const size_t from = strchr(text, '&') ? 0 : begin_of(text, root, line, &first);
    return span_from(text, from, line - first + 1, column, is_scalar, n_node, span) ||
           (from > 0 && span_from(text, 0, line, column, is_scalar, n_node, span));
}
