/* SPDX-License-Identifier: MIT
 *
 * Steps and registrations that every matching history has: those that stand in the expression's
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

static bool is_known(const struct search *search, const uint8_t *has)
{
    const struct rmap_path_table *table = search->table;
    for (int k = 0; k < table->n_need; k++)
        if (memcmp(table->need[k].has, has, table->n_symbol) == 0)
            return true;
    return false;
}

/* Only what steps alone or registrations alone can be: else it rules out little. */
static enum rmap_status add_atom(struct search *search, uint32_t atom)
{
    struct rmap_path_table *table = search->table;
    const uint32_t letters = search->regex->atom[atom].letters;
    const uint8_t *has = search->alphabet->has + (size_t)atom * table->n_symbol;
    bool is_hit = letters == 1u << RMAP_PATH_LETTER_V;
    if (!is_hit && letters & ~(uint32_t)RMAP_PATH_STEPS)
        return RMAP_OK;
    if (!is_known(search, has) && table->n_need < RMAP_PATH_NEED_MAX) {
        void *kept = NULL;
        enum rmap_status st = rmap_criterion_block_add(search->parser->criterion, table->n_symbol,
                                                       1, &kept, search->parser->err);
        if (st != RMAP_OK)
            return st;
        table->need[table->n_need++] =
            (struct rmap_path_need){memcpy(kept, has, table->n_symbol), is_hit};
    }
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
    return st == RMAP_OK ? fill_bits(&search) : st;
}
