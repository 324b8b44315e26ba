/* SPDX-License-Identifier: MIT
 *
 * Criteria from a stranger. The input is a text; what stands before its first '\r' alone is a file
 * of definitions, what stands behind it a criterion that may use them, and also a filter string of
 * Zemax. Each ends in a criterion that evaluates to 0s and 1s, or in a message with a place.
 */
#include <string.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_file.h"
#include "analysis/criterion/criterion_lex.h"
#include "analysis/report/zemax_filter.h"
#include "base/alloc.h"
#include "target.h"
#include "tests/criterion_scene.h"

const unsigned rmap_fuzz_rounds = 20000;

enum { N_RAY = 9, LONGEST = 4096 };

static void demand_message(enum rmap_status st, const struct rmap_error *err)
{
    rmap_fuzz_demand(st == RMAP_INPUT, "a refusal is RMAP_INPUT");
    rmap_fuzz_demand(strstr(err->text, ": error: ") != NULL, "a message has a place");
    rmap_fuzz_demand(strchr(err->text, '^') != NULL, "a message has a caret");
    rmap_fuzz_demand(rmap_criterion_check_utf8(err->text, NULL) == RMAP_OK, "a message is UTF-8");
}

static struct rmap_portion *make_portion(void)
{
    struct rmap_portion *portion = NULL;
    rmap_fuzz_demand(rmap_portion_create(N_RAY, 3, &portion, NULL) == RMAP_OK, "memory");
    for (int i = 0; i < N_RAY; i++) {
        bool good = test_add_ray(portion, &(struct test_ray){.id = (uint64_t)i, .source = i % 2});
        for (int s = 0; s < i; s++)
            good = good && test_add_step(portion, &(struct test_step){.object = s % 7 - 1,
                                                                      .event = 1u << s,
                                                                      .medium = (int16_t)(s % 3),
                                                                      .normal = {0, 0, 1}});
        good = good && test_add_registration(
                           portion, &(struct test_registration){.detector = i % 3,
                                                                .registered = i % 4 != 0,
                                                                .segment = (uint32_t)i / 2});
        rmap_fuzz_demand(good, "memory");
    }
    return portion;
}

static void try_criterion(const char *text, const struct rmap_criteria *criteria,
                          const struct rmap_scene *scene, const struct rmap_portion *portion)
{
    static const double flux_per_weight[] = {1.0, 1.0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[N_RAY];
    enum rmap_status st = rmap_criterion_compile_with(text, criteria, scene, &criterion, &err);
    if (st != RMAP_OK) {
        demand_message(st, &err);
        return;
    }
    st = rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err);
    rmap_fuzz_demand(st == RMAP_OK, "what compiles evaluates");
    for (int i = 0; i < N_RAY; i++)
        rmap_fuzz_demand(match[i] <= 1, "a match is 0 or 1");
    rmap_criterion_destroy(criterion);
}

static void try_zemax(const char *text, const struct rmap_scene *scene,
                      const struct rmap_portion *portion)
{
    struct rmap_error err = {0};
    char *criterion = NULL;
    enum rmap_status st = rmap_zemax_translate(text, scene, &criterion, &err);
    if (st != RMAP_OK) {
        demand_message(st, &err);
        return;
    }
    if (strlen(criterion) < LONGEST)
        try_criterion(criterion, NULL, scene, portion);
    rmap_free(criterion);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct test_scene t;
    char text[LONGEST + 1];
    struct rmap_criteria *criteria = NULL;
    struct rmap_error err = {0};
    if (nbytes > LONGEST)
        return 0;
    memcpy(text, data, nbytes);
    text[nbytes] = 0;
    test_scene_init(&t);
    struct rmap_portion *portion = make_portion();
    char *question = strchr(text, '\r');
    if (question) {
        *question++ = 0;
        enum rmap_status st = rmap_criteria_create(text, "criteria", &criteria, &err);
        if (st != RMAP_OK)
            demand_message(st, &err);
    }
    for (size_t i = 0; criteria && i < rmap_criteria_count(criteria); i++)
        try_criterion(rmap_criteria_reference(criteria, i), criteria, &t.scene, portion);
    try_criterion(question ? question : text, criteria, &t.scene, portion);
    try_zemax(question ? question : text, &t.scene, portion);
    rmap_criteria_destroy(criteria);
    rmap_portion_destroy(portion);
    rmap_fuzz_demand(rmap_alloc_live() == 0, "nothing is leaked");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "path(\"T@lens.1+ R@'l*' .* V@sensor\") and hit(tube, face 0..2, absorb) >= 2",
        "path(\"([TR]@lens|[^AV]{1,3})* (A@ink|X V?)+\") == 0 or not path(\".*\")",
        "path(\"((D|d)?S{2}){0,4}.@housing{2,}K*\")",
        "let a = hit(tube) # no\nlet 'b c' = not @a or path(\"T.*\")\r@a and @'b c'",
        "let a = @b and @b\nlet b = @c or @c let c = all\rnot (@a | @b) & registered(sensor)",
        "H3 & R5 & !G | (M1 ^ T2) & S0 & X_HITFACE(2,1) & L1 & O1 & B0",
        "registered(sensor, rect(-1 mm, 0, 1e1, .5) where angle < 10 deg and (x > 0 or !y != 2))",
        "wavelength in 0.4..0.6 um and surface(reflectance < 0.1, absorb) in 1..3",
        "hit(tube where 2 * length < path_length - 1e-1 cm and step > 1 and x - y > z) > 1",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
