/* SPDX-License-Identifier: MIT
 *
 * Kinds and symbols of a path: partitions, refined by one name or atom after another, so that what
 * the expression cannot tell apart costs nothing.
 */
#include <string.h>

#include "analysis/criterion/path_table.h"
#include "base/alloc.h"
#include "portion/event.h"

enum {
    KIND_MAX = 4000,
    SYMBOL_MAX = 30000,
    STEP_LETTERS = RMAP_PATH_LETTER_V,
    NO_LETTER = STEP_LETTERS
};

/* Elements with a class each. */
struct partition {
    size_t n, n_class;
    uint32_t *class; /* [n] */
    uint32_t *moved; /* [2 n]: 1 + new class of a split one, during a refinement */
    uint8_t *marked; /* [n], zero between refinements */
};

static enum rmap_status partition_init(struct partition *partition, size_t n,
                                       struct rmap_error *err)
{
    *partition = (struct partition){.n = n, .n_class = 1};
    partition->class = rmap_alloc(n, sizeof *partition->class);
    partition->moved = rmap_alloc(2 * n, sizeof *partition->moved);
    partition->marked = rmap_alloc(n, sizeof *partition->marked);
    if (!partition->class || !partition->moved || !partition->marked)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path's symbols");
    return RMAP_OK;
}

static void partition_fini(struct partition *partition)
{
    rmap_free(partition->class);
    rmap_free(partition->moved);
    rmap_free(partition->marked);
}

/* Numbers the classes in use from 0, in the order of their first elements. */
static void partition_number(struct partition *partition)
{
    size_t n = 0;
    memset(partition->moved, 0, 2 * partition->n * sizeof *partition->moved);
    for (size_t i = 0; i < partition->n; i++) {
        uint32_t *number = &partition->moved[partition->class[i]];
        if (!*number)
            *number = (uint32_t)++n;
        partition->class[i] = *number - 1;
    }
    partition->n_class = n;
}

/* Splits classes that are marked in part; marks are taken off. */
static void partition_refine(struct partition *partition)
{
    size_t n_class = partition->n_class;
    memset(partition->moved, 0, n_class * sizeof *partition->moved);
    for (size_t i = 0; i < partition->n; i++) {
        if (!partition->marked[i])
            continue;
        partition->marked[i] = 0;
        uint32_t *number = &partition->moved[partition->class[i]];
        if (!*number)
            *number = (uint32_t)++partition->n_class;
        partition->class[i] = *number - 1;
    }
    if (partition->n_class != n_class)
        partition_number(partition);
}

static void mark_set(const struct rmap_index_set *set, uint8_t *mark)
{
    for (uint32_t i = 0; i < set->span; i++)
        if (!set->member || set->member[i])
            mark[(uint32_t)set->low + i] = 1;
}

/* Kinds of objects, of media, and of what is neither: [objects, media, other]. */
static enum rmap_status find_kinds(struct rmap_parser *parser, const struct rmap_token *string,
                                   const struct rmap_path_regex *regex,
                                   struct rmap_path_table *table, struct partition *kind)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(partition_init(kind, table->n_object + table->n_medium + 1, parser->err));
    /* An object and a medium may have one name, and yet are not one kind. */
    for (size_t i = table->n_object; i < kind->n; i++)
        kind->class[i] = 1;
    partition_number(kind);
    for (size_t p = 0; p < regex->n_place; p++) {
        const struct rmap_path_place *place = &regex->place[p];
        mark_set(&place->object, kind->marked);
        mark_set(&place->medium, kind->marked + table->n_object);
        table->of_object |= place->object.span > 0;
        table->of_medium |= place->medium.span > 0;
        partition_refine(kind);
        if (kind->n_class > KIND_MAX)
            return RMAP_PARSER_FAIL(parser, string,
                                    "this path is too complex: its names tell more than %d groups "
                                    "of objects apart",
                                    KIND_MAX);
    }
out:
    return st;
}

/* Copies n numbers into memory of the criterion, `other` behind them. */
static enum rmap_status keep(struct rmap_parser *parser, const uint32_t *from, size_t n,
                             uint32_t other, const uint16_t **kept_ret)
{
    void *block = NULL;
    uint16_t *kept = NULL;
    enum rmap_status st =
        rmap_criterion_block_add(parser->criterion, n + 1, sizeof *kept, &block, parser->err);
    if (st != RMAP_OK)
        return st;
    kept = block;
    for (size_t i = 0; i < n; i++)
        kept[i] = (uint16_t)from[i];
    kept[n] = (uint16_t)other;
    *kept_ret = kept;
    return RMAP_OK;
}

/* Letters of all sets of events, once per criterion. */
static enum rmap_status keep_letters(struct rmap_parser *parser)
{
    void *block = NULL;
    if (parser->path_letters)
        return RMAP_OK;
    enum rmap_status st =
        rmap_criterion_block_add(parser->criterion, RMAP_PATH_EVENT_CODES, 1, &block, parser->err);
    if (st != RMAP_OK)
        return st;
    uint8_t *letter = block;
    for (uint32_t events = 0; events < RMAP_PATH_EVENT_CODES; events++) {
        char c = rmap_event_letter(events);
        letter[events] =
            (uint8_t)(c ? strchr(RMAP_PATH_LETTERS, c) - RMAP_PATH_LETTERS : NO_LETTER);
    }
    parser->path_letters = letter;
    return RMAP_OK;
}

static enum rmap_status keep_kinds(struct rmap_parser *parser, const struct partition *kind,
                                   struct rmap_path_table *table)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t *medium = kind->class + table->n_object;
    uint32_t other = kind->class[kind->n - 1];
    table->n_kind = (uint16_t)kind->n_class;
    RMAP_TRY(keep_letters(parser));
    table->letter_of_event = parser->path_letters;
    RMAP_TRY(keep(parser, kind->class, table->n_object, other, &table->kind_of_object));
    RMAP_TRY(keep(parser, medium, table->n_medium, other, &table->kind_of_medium));
out:
    return st;
}

/* What an atom matches: letter by kind, then detectors. first[k]: an element of kind k. */
static void mark_atom(const struct rmap_path_table *table, const struct rmap_path_regex *regex,
                      const struct rmap_path_atom *atom, const uint32_t *first, size_t n_kind,
                      uint8_t *mark)
{
    const struct rmap_path_place *place = atom->place < 0 ? NULL : &regex->place[atom->place];
    uint8_t *detector = mark + (STEP_LETTERS + 1) * n_kind;
    for (int letter = 0; letter < STEP_LETTERS; letter++) {
        if (!(atom->letters >> letter & 1))
            continue;
        bool inside = RMAP_PATH_INSIDE >> letter & 1;
        for (size_t k = 0; k < n_kind; k++) {
            bool is_object = first[k] < table->n_object;
            bool has = !place ||
                       (is_object && rmap_index_set_has(&place->object, (int32_t)first[k])) ||
                       (!is_object && inside &&
                        rmap_index_set_has(&place->medium, (int32_t)(first[k] - table->n_object)));
            mark[(size_t)letter * n_kind + k] = has;
        }
    }
    if (!(atom->letters >> RMAP_PATH_LETTER_V & 1))
        return;
    if (place)
        mark_set(&place->detector, detector);
    else
        memset(detector, 1, table->n_detector);
}

/* alphabet->has, from an element of each symbol. */
static enum rmap_status fill_has(const struct rmap_path_table *table,
                                 const struct rmap_path_regex *regex, const uint32_t *first,
                                 size_t n_kind, struct partition *symbol,
                                 struct rmap_path_alphabet *alphabet, struct rmap_error *err)
{
    alphabet->n_symbol = (uint32_t)symbol->n_class;
    alphabet->has = rmap_alloc(regex->n_atom, symbol->n_class);
    if (!alphabet->has)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path's symbols");
    for (size_t a = 0; a < regex->n_atom; a++) {
        uint8_t *has = alphabet->has + a * symbol->n_class;
        memset(symbol->marked, 0, symbol->n);
        mark_atom(table, regex, &regex->atom[a], first, n_kind, symbol->marked);
        for (size_t i = 0; i < symbol->n; i++)
            has[symbol->class[i]] |= symbol->marked[i];
    }
    return RMAP_OK;
}

enum rmap_status rmap_path_alphabet_create(struct rmap_parser *parser,
                                           const struct rmap_token *string,
                                           const struct rmap_path_regex *regex,
                                           struct rmap_path_table *table,
                                           struct rmap_path_alphabet *alphabet)
{
    enum rmap_status st = RMAP_OK;
    struct partition kind = {0}, symbol = {0};
    uint32_t *first = NULL;
    RMAP_TRY(find_kinds(parser, string, regex, table, &kind));
    RMAP_TRY(keep_kinds(parser, &kind, table));
    first = rmap_alloc(kind.n_class, sizeof *first);
    if (!first) {
        st = rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for a path's symbols");
        goto out;
    }
    for (size_t i = kind.n; i-- > 0;)
        first[kind.class[i]] = (uint32_t)i;
    size_t n_step = (STEP_LETTERS + 1) * kind.n_class;
    RMAP_TRY(partition_init(&symbol, n_step + table->n_detector, parser->err));
    for (size_t a = 0; a < regex->n_atom; a++) {
        mark_atom(table, regex, &regex->atom[a], first, kind.n_class, symbol.marked);
        partition_refine(&symbol);
    }
    if (symbol.n_class > SYMBOL_MAX) {
        st = RMAP_PARSER_FAIL(parser, string,
                              "this path is too complex: it tells %zu kinds of "
                              "steps apart",
                              symbol.n_class);
        goto out;
    }
    RMAP_TRY(fill_has(table, regex, first, kind.n_class, &symbol, alphabet, parser->err));
    table->n_symbol = alphabet->n_symbol;
    RMAP_TRY(keep(parser, symbol.class, n_step, 0, &table->symbol_of_base));
    RMAP_TRY(keep(parser, symbol.class + n_step, table->n_detector,
                  symbol.class[NO_LETTER * kind.n_class], &table -> symbol_of_hit));
out:
    rmap_free(first);
    partition_fini(&symbol);
    partition_fini(&kind);
    return st;
}
