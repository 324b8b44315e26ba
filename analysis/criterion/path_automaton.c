/* SPDX-License-Identifier: MIT
 *
 * From a regular expression to a deterministic automaton: Thompson's construction (Thompson 1968,
 * doi:10.1145/363347.363387), built from the end so that every part knows what follows it, then
 * sets of its nodes. Work, nodes, states and memory are bounded, whatever the expression.
 */
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/path_table.h"
#include "base/alloc.h"

enum {
    NODE_MAX = 1 << 16,
    STATE_MAX = 1 << 14,
    SET_MAX = 1 << 22,   /* nodes of all states together */
    ENTRY_MAX = 1 << 22, /* of the table: 16 MiB */
    WORK_MAX = 1 << 26   /* nodes looked at for all paths of a criterion: about a second */
};

/* A node that takes a symbol of its atom, splits, or accepts. */
enum { NODE_SPLIT = -1, NODE_ACCEPT = -2 };
struct node {
    int32_t atom; /* or NODE_... */
    uint32_t next, other;
};

struct build {
    struct rmap_parser *parser;
    const struct rmap_token *string;
    const struct rmap_path_regex *regex;
    const struct rmap_path_alphabet *alphabet;
    struct node *node;
    size_t n_node, node_cap;
    size_t work;

    /* States are sorted sets of nodes that take a symbol or accept. */
    uint32_t *member;
    size_t n_member, member_cap;
    struct state {
        size_t first, n; /* of member */
        uint32_t hash;
    } * state;
    size_t n_state, state_cap;
    uint32_t *slot; /* [2 * STATE_MAX] 1 + state, by hash */
    uint32_t *next; /* [n_state][n_symbol] */
    size_t next_cap;
    uint32_t *stamp; /* [n_node] number of the last set that has the node */
    uint32_t *stack; /* [2 * n_node + 2] */
    uint32_t n_set;
};

static enum rmap_status fail_complex(const struct build *build, const char *what, int most)
{
    return RMAP_PARSER_FAIL(build->parser, build->string,
                            "this path is too complex: it needs more than %d %s", most, what);
}

/* Spent on all the paths so far. */
static enum rmap_status fail_work(const struct build *build)
{
    return fail_complex(build, "steps of work to be understood", WORK_MAX);
}

static enum rmap_status add_node(struct build *build, struct node node, uint32_t *index_ret)
{
    enum rmap_status st =
        RMAP_RESERVE(build->node, build->node_cap, build->n_node + 1, build->parser->err);
    if (st != RMAP_OK)
        return st;
    *index_ret = (uint32_t)build->n_node;
    build->node[build->n_node++] = node;
    return RMAP_OK;
}

static enum rmap_status emit(struct build *build, int32_t index, uint32_t next, uint32_t *entry);

static enum rmap_status emit_repeat(struct build *build, const struct rmap_path_term *term,
                                    uint32_t next, uint32_t *entry)
{
    enum rmap_status st = RMAP_OK;
    uint32_t at = next;
    if (term->most == RMAP_PATH_UNBOUNDED) {
        RMAP_TRY(add_node(build, (struct node){NODE_SPLIT, next, next}, &at));
        uint32_t body = 0;
        RMAP_TRY(emit(build, term->last, at, &body));
        build->node[at].other = body;
    }
    for (uint32_t i = term->least; term->most != RMAP_PATH_UNBOUNDED && i < term->most; i++) {
        RMAP_TRY(emit(build, term->last, at, &at));
        RMAP_TRY(add_node(build, (struct node){NODE_SPLIT, at, next}, &at));
    }
    for (uint32_t i = 0; i < term->least; i++)
        RMAP_TRY(emit(build, term->last, at, &at));
    *entry = at;
out:
    return st;
}

static enum rmap_status emit_choice(struct build *build, int32_t last, uint32_t next,
                                    uint32_t *entry)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(emit(build, last, next, entry));
    for (int32_t child = build->regex->term[last].prev; child >= 0;
         child = build->regex->term[child].prev) {
        uint32_t own = 0;
        RMAP_TRY(emit(build, child, next, &own));
        RMAP_TRY(add_node(build, (struct node){NODE_SPLIT, own, *entry}, entry));
    }
out:
    return st;
}

/* Nodes for a term that goes on at node `next`; *entry: where it begins. */
static enum rmap_status emit(struct build *build, int32_t index, uint32_t next, uint32_t *entry)
{
    const struct rmap_path_term *term = &build->regex->term[index];
    enum rmap_status st = RMAP_OK;
    if (build->n_node > NODE_MAX)
        return fail_complex(build, "steps with their repetitions", NODE_MAX);
    if (++build->work > WORK_MAX)
        return fail_work(build);
    switch (term->kind) {
    case RMAP_PATH_ATOM:
        return add_node(build, (struct node){(int32_t)term->atom, next, next}, entry);
    case RMAP_PATH_SEQUENCE:
        *entry = next;
        for (int32_t child = term->last; child >= 0; child = build->regex->term[child].prev)
            RMAP_TRY(emit(build, child, *entry, entry));
        break;
    case RMAP_PATH_CHOICE:
        st = emit_choice(build, term->last, next, entry);
        break;
    case RMAP_PATH_REPEAT:
        st = emit_repeat(build, term, next, entry);
        break;
    }
out:
    return st;
}

static int by_number(const void *left, const void *right)
{
    const uint32_t *a = left, *b = right;
    return (*a > *b) - (*a < *b);
}

/* Adds what is reached from a node without a symbol to the set that is being made: the members
 * behind those of the last state. */
static enum rmap_status add_closure(struct build *build, uint32_t from, size_t *n)
{
    size_t n_stack = 0;
    build->stack[n_stack++] = from;
    while (n_stack > 0) {
        uint32_t index = build->stack[--n_stack];
        const struct node *node = &build->node[index];
        build->work++;
        if (build->stamp[index] == build->n_set)
            continue;
        build->stamp[index] = build->n_set;
        if (node->atom == NODE_SPLIT) {
            build->stack[n_stack++] =
                node->next; /* twice per split at most: see the stack's size */
            build->stack[n_stack++] = node->other;
            continue;
        }
        enum rmap_status st = RMAP_RESERVE(build->member, build->member_cap,
                                           build->n_member + *n + 1, build->parser->err);
        if (st != RMAP_OK)
            return st;
        build->member[build->n_member + (*n)++] = index;
    }
    return RMAP_OK;
}

static uint32_t hash_of(const uint32_t *member, size_t n)
{
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a, by numbers instead of bytes */
    for (size_t i = 0; i < n; i++)
        hash = (hash ^ member[i]) * 0x100000001b3u;
    return (uint32_t)(hash ^ hash >> 32);
}

static enum rmap_status add_state(struct build *build, size_t n, uint32_t hash)
{
    enum rmap_status st = RMAP_OK;
    void *block = build->state;
    if (build->n_state == STATE_MAX)
        return fail_complex(build, "states", STATE_MAX);
    if (build->n_member + n > SET_MAX)
        return fail_complex(build, "steps in all its states together", SET_MAX);
    if ((build->n_state + 1) * (2 * build->alphabet->n_symbol + 1) > ENTRY_MAX)
        return fail_complex(build, "entries in its table of states and symbols", ENTRY_MAX);
    RMAP_TRY(rmap_reserve(&block, &build->state_cap, build->n_state + 1, sizeof *build->state,
                          build->parser->err));
    build->state = block;
    block = build->next;
    RMAP_TRY(rmap_reserve(&block, &build->next_cap,
                          (build->n_state + 1) * build->alphabet->n_symbol, sizeof *build->next,
                          build->parser->err));
    build->next = block;
    build->state[build->n_state++] = (struct state){build->n_member, n, hash};
    build->n_member += n;
out:
    return st;
}

/* The state of the set that was made, a new one if need be. */
static enum rmap_status find_state(struct build *build, size_t n, uint32_t *state_ret)
{
    uint32_t *member = build->member + build->n_member;
    if (n > 1)
        qsort(member, n, sizeof *member, by_number);
    build->work += 4 * n;
    uint32_t hash = hash_of(member, n);
    size_t at = hash % (2 * STATE_MAX);
    for (; build->slot[at]; at = (at + 1) % (2 * STATE_MAX)) {
        const struct state *state = &build->state[build->slot[at] - 1];
        if (state->hash == hash && state->n == n &&
            memcmp(build->member + state->first, member, n * sizeof *member) == 0) {
            *state_ret = build->slot[at] - 1;
            return RMAP_OK;
        }
    }
    *state_ret = (uint32_t)build->n_state;
    build->slot[at] = *state_ret + 1;
    return add_state(build, n, hash);
}

static enum rmap_status add_transition(struct build *build, size_t from, uint32_t symbol)
{
    enum rmap_status st = RMAP_OK;
    const struct state state = build->state[from];
    size_t n = 0;
    build->n_set++;
    for (size_t i = 0; i < state.n; i++) {
        const struct node *node = &build->node[build->member[state.first + i]];
        build->work++;
        if (node->atom >= 0 &&
            build->alphabet->has[(size_t)node->atom * build->alphabet->n_symbol + symbol])
            RMAP_TRY(add_closure(build, node->next, &n));
    }
    if (build->work > WORK_MAX)
        return fail_work(build);
    uint32_t to = 0;
    RMAP_TRY(find_state(build, n, &to));
    build->next[from * build->alphabet->n_symbol + symbol] = to;
out:
    return st;
}

static enum rmap_status determinise(struct build *build, uint32_t entry)
{
    enum rmap_status st = RMAP_OK;
    uint32_t first = 0;
    size_t n = 0;
    build->slot = rmap_alloc(2 * STATE_MAX, sizeof *build->slot);
    build->stamp = rmap_alloc(build->n_node, sizeof *build->stamp);
    build->stack = rmap_alloc(2 * build->n_node + 2, sizeof *build->stack);
    if (!build->slot || !build->stamp || !build->stack)
        return rmap_error_set(build->parser->err, RMAP_SYSTEM, "out of memory for a path");
    build->n_set = 1;
    /* Room for the empty set too, whose members are none. */
    RMAP_TRY(RMAP_RESERVE(build->member, build->member_cap, 1, build->parser->err));
    RMAP_TRY(add_closure(build, entry, &n));
    RMAP_TRY(find_state(build, n, &first));
    for (size_t from = 0; from < build->n_state; from++)
        for (uint32_t symbol = 0; symbol < build->alphabet->n_symbol; symbol++)
            RMAP_TRY(add_transition(build, from, symbol));
out:
    return st;
}

/* Node 0 accepts. */
static bool accepts(const struct build *build, uint32_t state)
{
    return build->state[state].n > 0 && build->member[build->state[state].first] == 0;
}

/* The table: states 0 and 1 are both the first one, so that a ray's end says whether it matched;
 * others follow. */
static enum rmap_status fill_table(struct build *build, struct rmap_path_table *table)
{
    enum rmap_status st = RMAP_OK;
    uint32_t n_symbol = build->alphabet->n_symbol;
    void *block = NULL;
    table->width = 2 * n_symbol + 1;
    table->n_state = (uint32_t)build->n_state + 1;
    build->work += 4 * (size_t)table->n_state * table->width; /* memory is bounded too */
    RMAP_TRY(rmap_criterion_block_add(build->parser->criterion,
                                      (size_t)table->n_state * table->width, sizeof(uint32_t),
                                      &block, build->parser->err));
    uint32_t *next = block;
    for (uint32_t row = 0; row < table->n_state; row++, next += table->width) {
        uint32_t state = row > 0 ? row - 1 : 0;
        for (uint32_t symbol = 0; symbol < n_symbol; symbol++) {
            uint32_t to = build->next[(size_t)state * n_symbol + symbol];
            next[symbol] = (to + 1) * table->width;
            next[n_symbol + symbol] = accepts(build, to) ? table->width : 0;
        }
        next[2 * (size_t)n_symbol] = accepts(build, state) ? table->width : 0;
    }
    table->next = block;
out:
    return st;
}

/* Symbols that do not lead from the first state to the empty set. */
static enum rmap_status fill_first(struct build *build, struct rmap_path_table *table)
{
    uint32_t n_symbol = build->alphabet->n_symbol, n = 0;
    void *block = NULL;
    enum rmap_status st =
        rmap_criterion_block_add(build->parser->criterion, n_symbol, 1, &block, build->parser->err);
    if (st != RMAP_OK)
        return st;
    uint8_t *first = block;
    for (uint32_t symbol = 0; symbol < n_symbol; symbol++) {
        first[symbol] = build->state[build->next[symbol]].n > 0;
        n += first[symbol];
    }
    table->first = n < n_symbol ? first : NULL;
    return RMAP_OK;
}

enum rmap_status rmap_path_automaton_create(struct rmap_parser *parser,
                                            const struct rmap_token *string,
                                            const struct rmap_path_regex *regex,
                                            const struct rmap_path_alphabet *alphabet,
                                            struct rmap_path_table *table)
{
    enum rmap_status st = RMAP_OK;
    struct build build = {.parser = parser,
                          .string = string,
                          .regex = regex,
                          .alphabet = alphabet,
                          .work = parser->path_work};
    uint32_t entry = 0;
    RMAP_TRY(add_node(&build, (struct node){NODE_ACCEPT, 0, 0}, &entry));
    RMAP_TRY(emit(&build, regex->root, entry, &entry));
    RMAP_TRY(determinise(&build, entry));
    RMAP_TRY(fill_table(&build, table));
    RMAP_TRY(fill_first(&build, table));
out:
    parser->path_work = build.work;
    rmap_free(build.stack);
    rmap_free(build.stamp);
    rmap_free(build.next);
    rmap_free(build.slot);
    rmap_free(build.state);
    rmap_free(build.member);
    rmap_free(build.node);
    return st;
}
