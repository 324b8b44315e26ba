/* SPDX-License-Identifier: MIT
 *
 * Steps that every matching history has, in their order: those that stand in the expression's
 * sequence outside of choices and of what may be left out.
 */
#include <string.h>

#include "analysis/criterion/path_table.h"

struct search {
    struct rmap_parser *parser;
    const struct rmap_path_regex *regex;
    const struct rmap_path_alphabet *alphabet;
    struct rmap_path_table *table;
};

/* The table's own copy, or NULL. */
static const uint8_t *find(const struct search *search, const uint8_t *has)
{
    const struct rmap_path_table *table = search->table;
    for (int k = 0; k < table->n_need; k++)
        if (memcmp(table->need[k].has, has, table->n_symbol) == 0)
            return table->need[k].has;
    return NULL;
}

/* Only what steps alone or registrations alone can be: else it rules out little. Atoms come last
 * one first. */
static enum rmap_status add_atom(struct search *search, uint32_t atom)
{
    struct rmap_path_table *table = search->table;
    const uint32_t letters = search->regex->atom[atom].letters;
    const uint8_t *has = search->alphabet->has + (size_t)atom * table->n_symbol;
    const uint8_t *known = find(search, has);
    bool is_hit = letters == 1u << RMAP_PATH_LETTER_V;
    if (!is_hit && letters & ~(uint32_t)RMAP_PATH_STEPS)
        return RMAP_OK;
    if (!known && table->n_need < RMAP_PATH_NEED_MAX) {
        void *kept = NULL;
        enum rmap_status st = rmap_criterion_block_add(search->parser->criterion, table->n_symbol,
                                                       1, &kept, search->parser->err);
        if (st != RMAP_OK)
            return st;
        known = memcpy(kept, has, table->n_symbol);
        table->need[table->n_need++] = (struct rmap_path_need){known, is_hit};
    }
    if (known && !is_hit && table->n_chain < RMAP_PATH_CHAIN_MAX)
        table->chain[table->n_chain++] = known;
    return RMAP_OK;
}

static enum rmap_status add_term(struct search *search, int32_t index)
{
    const struct rmap_path_term *term = &search->regex->term[index];
    enum rmap_status st = RMAP_OK;
    if (term->kind == RMAP_PATH_ATOM)
        return add_atom(search, term->atom);
    if (term->kind == RMAP_PATH_CHOICE || (term->kind == RMAP_PATH_REPEAT && term->least == 0))
        return RMAP_OK;
    for (int32_t child = term->last; child >= 0 && st == RMAP_OK;
         child = search->regex->term[child].prev)
        st = add_term(search, child);
    return st;
}

/* Any number of anything. */
static bool is_gap(const struct rmap_path_regex *regex, int32_t index)
{
    const struct rmap_path_term *term = &regex->term[index];
    if (term->kind != RMAP_PATH_REPEAT || term->least > 0 || term->most != RMAP_PATH_UNBOUNDED ||
        regex->term[term->last].kind != RMAP_PATH_ATOM)
        return false;
    const struct rmap_path_atom *atom = &regex->atom[regex->term[term->last].atom];
    return atom->letters == RMAP_PATH_ANY && atom->place < 0;
}

/* Whether the expression is its steps, perhaps a registration behind them, and gaps in between and
 * at the end, each of which the table has kept. */
static void find_chain(const struct search *search)
{
    const struct rmap_path_regex *regex = search->regex;
    struct rmap_path_table *table = search->table;
    const struct rmap_path_term *root = &regex->term[regex->root];
    int32_t child = root->kind == RMAP_PATH_SEQUENCE ? root->last : -1;
    const uint8_t *seen = NULL;
    bool gap = true, is_last = true;
    int n_step = 0;
    for (; child >= 0; child = regex->term[child].prev, gap = !gap) {
        const struct rmap_path_term *term = &regex->term[child];
        if (gap != is_gap(regex, child) || (!gap && term->kind != RMAP_PATH_ATOM))
            return;
        if (gap)
            continue;
        const uint32_t letters = regex->atom[term->atom].letters;
        if (is_last && letters == 1u << RMAP_PATH_LETTER_V)
            seen = find(search, search->alphabet->has + (size_t)term->atom * table->n_symbol);
        n_step += !(is_last && seen);
        is_last = false;
    }
    table->is_chain = n_step > 0 && n_step == table->n_chain;
    table->is_from_start = gap; /* a gap would have come next */
    table->seen = seen;
}

/* Needs as bits of symbols. */
static enum rmap_status fill_bits(struct search *search)
{
    struct rmap_path_table *table = search->table;
    void *block = NULL;
    enum rmap_status st = rmap_criterion_block_add(search->parser->criterion, table->n_symbol, 1,
                                                   &block, search->parser->err);
    uint8_t *met = block;
    for (int k = 0; st == RMAP_OK && k < table->n_need; k++)
        for (uint32_t symbol = 0; symbol < table->n_symbol; symbol++)
            met[symbol] |= (uint8_t)(table->need[k].has[symbol] << k);
    table->needs_met = met;
    return st;
}

enum rmap_status rmap_path_needs_create(struct rmap_parser *parser,
                                        const struct rmap_path_regex *regex,
                                        const struct rmap_path_alphabet *alphabet,
                                        struct rmap_path_table *table)
{
    struct search search = {parser, regex, alphabet, table};
    enum rmap_status st = add_term(&search, regex->root);
    for (int k = 0; k < table->n_chain / 2; k++) {
        const uint8_t *other = table->chain[table->n_chain - 1 - k];
        table->chain[table->n_chain - 1 - k] = table->chain[k];
        table->chain[k] = other;
    }
    if (st == RMAP_OK)
        find_chain(&search);
    return st == RMAP_OK ? fill_bits(&search) : st;
}
