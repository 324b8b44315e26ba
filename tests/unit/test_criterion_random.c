/* SPDX-License-Identifier: MIT
 *
 * Random criteria over random rays, against an evaluator of its own that goes ray by ray and row
 * by row and shares nothing with the one under test but the text.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_evaluate.h"
#include "base/alloc.h"
#include "base/rng.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 257, N_CRITERION = 1500, TEXT = 8192 };

static const double flux_per_weight[] = {0.5, 0.25};

/* A draw in [0, n). */
struct dice {
    uint64_t seed;
    uint32_t draw;
};

static int roll(struct dice *dice, int n)
{
    double u[4];
    rmap_rng(dice->seed, 11, dice->draw++, 0, u);
    return (int)(u[0] * n);
}

static void roll_steps(struct dice *dice, struct rmap_portion *portion)
{
    int n = roll(dice, 8) == 0 ? 0 : 1 + roll(dice, 9);
    for (int s = 0; s < n; s++) {
        struct test_step step = {.object = roll(dice, 7) - 1,
                                 .primitive = roll(dice, 8),
                                 .event = 1u << roll(dice, 13),
                                 .medium = (int16_t)roll(dice, 3)};
        if (roll(dice, 4) == 0)
            step.event |= 1u << roll(dice, 13);
        for (int k = 0; k < 3; k++) {
            step.position[k] = (float)roll(dice, 3);
            step.normal[k] = (int16_t)(roll(dice, 3) - 1);
        }
        assert_true(test_add_step(portion, &step));
    }
    for (int r = roll(dice, 5) - 1; r > 0; r--) {
        struct test_registration seen = {.detector = roll(dice, 3),
                                         .cell = {(uint16_t)roll(dice, 5), (uint16_t)roll(dice, 5)},
                                         .registered = (uint8_t)roll(dice, 2),
                                         .optical_path = roll(dice, 5)};
        for (int k = 0; k < 2; k++)
            seen.relative[k] = (uint16_t)(roll(dice, 6) * 13107);
        for (int k = 0; k < 3; k++)
            seen.direction[k] = (float)(roll(dice, 3) - 1);
        seen.direction[roll(dice, 3)] = 1.0f;
        assert_true(test_add_registration(portion, &seen));
    }
}

static struct rmap_portion *roll_portion(struct dice *dice)
{
    struct rmap_portion *portion = NULL;
    assert_int_equal(rmap_portion_create(N_RAY, 3, &portion, NULL), RMAP_OK);
    for (int i = 0; i < N_RAY; i++) {
        struct test_ray ray = {.id = (uint64_t)(1000 + i),
                               .source = roll(dice, 2),
                               .stop = (uint8_t)roll(dice, 4),
                               .weight = roll(dice, 4),
                               .wavelength = roll(dice, 4) ? 400 + 50 * roll(dice, 5) : (double)NAN,
                               .path_length = roll(dice, 10),
                               .optical_path = roll(dice, 10),
                               .start = {(float)roll(dice, 3), 0, 1}};
        assert_true(test_add_ray(portion, &ray));
        roll_steps(dice, portion);
    }
    return portion;
}

/* One ray's rows. */
struct history {
    const struct rmap_portion *p;
    const struct rmap_scene *scene;
    size_t ray, first_step, n_step, first_seen, n_seen;
};

/* A criterion in the making: its text, and its truth for every ray. */
struct formula {
    char text[TEXT];
    bool truth[N_RAY];
};

struct maker {
    struct dice dice;
    struct history history[N_RAY];
};

static void write_text(struct formula *f, const char *format, ...)
{
    size_t len = strlen(f->text);
    va_list args;
    va_start(args, format);
    assert_true(vsnprintf(f->text + len, TEXT - len, format, args) < (int)(TEXT - len));
    va_end(args);
}

/* Comparisons: a random one with its text; v is the number it compares with. */
struct comparison {
    int relation;
    double v, w;
};

static struct comparison roll_comparison(struct dice *dice, double low, double step, int n)
{
    struct comparison c = {roll(dice, 7), low + step * roll(dice, n), 0};
    c.w = c.v + step * roll(dice, 3);
    return c;
}

static void write_comparison(struct formula *f, const struct comparison *c, const char *unit)
{
    static const char *const relation[] = {"==", "!=", "<", "<=", ">", ">="};
    if (c->relation == 6)
        write_text(f, " in %.17g..%.17g%s", c->v, c->w, unit);
    else
        write_text(f, " %s %.17g%s", relation[c->relation], c->v, unit);
}

static bool compares(const struct comparison *c, double x)
{
    if (isnan(x))
        return false;
    switch (c->relation) {
    case 0:
        return x == c->v;
    case 1:
        return x != c->v;
    case 2:
        return x < c->v;
    case 3:
        return x <= c->v;
    case 4:
        return x > c->v;
    case 5:
        return x >= c->v;
    default:
        return c->v <= x && x <= c->w;
    }
}

/* Names and what they stand for: bits of object indices. */
static const struct {
    const char *name;
    unsigned objects;
} object_names[] = {
    {"lens.1", 1}, {"tube", 2},     {"lens.2", 4},
    {"cover", 8},  {"mirror", 16},  {"'odd n\xc3\xa4me'", 32},
    {"lens", 5},   {"housing", 15}, {"*", 63},
    {"lens*", 5},  {"?????", 8},    {"h*", 15},
    {"*e*", 47},   {"*.?", 5},
};

static const struct {
    const char *name;
    uint32_t bits;
} event_names[] = {
    {"reflect_specular", 1}, {"reflect_diffuse", 2},   {"transmit_specular", 4},
    {"transmit_diffuse", 8}, {"total_reflection", 16}, {"absorb", 32},
    {"scatter_volume", 64},  {"fluoresce", 128},       {"gradient", 256},
    {"element", 512},        {"left", 1024},           {"limit", 2048},
    {"error", 4096},         {"reflect", 19},          {"transmit", 12},
    {"specular", 21},        {"diffuse", 10},          {"scatter", 74},
};
#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static bool is_object(unsigned objects, int32_t object)
{
    return object >= 0 && (objects >> object & 1);
}

static void make_hit(struct maker *m, struct formula *f, const struct comparison *c)
{
    int name = roll(&m->dice, COUNT(object_names));
    int event = roll(&m->dice, 2 * COUNT(event_names)) - COUNT(event_names);
    int part = roll(&m->dice, 6), low = roll(&m->dice, 3), high = low + roll(&m->dice, 3);
    unsigned objects = object_names[name].objects;
    bool has_face = part == 0 && (low == 0 || (objects & 2));
    bool has_triangle = part == 1 && (low == 0 || (objects & 2));
    write_text(f, "hit(%s", object_names[name].name);
    if (has_face)
        write_text(f, ", face %d..%d", low, high);
    if (event >= 0)
        write_text(f, ", %s", event_names[event].name);
    if (has_triangle)
        write_text(f, ", triangle %d..%d", low, high);
    write_text(f, ")");
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        int n = 0;
        for (size_t s = h->first_step; s < h->first_step + h->n_step; s++) {
            int object = h->p->segment.object[s], primitive = h->p->segment.primitive[s];
            static const int face_of[] = {0, 0, 0, 1, 1, 2, 2, 2};
            int face = object == 1 ? face_of[primitive] : 0;
            if (is_object(objects, object) &&
                (event < 0 || (h->p->segment.event[s] & event_names[event].bits)) &&
                !(has_face && (face < low || face > high)) &&
                !(has_triangle && (primitive < low || primitive > high)))
                n++;
        }
        f->truth[i] = compares(c, n);
    }
}

/* Which side a step met, by the rules of docs/criterion.md: 0 front, 1 back, -1 neither. */
static int side_met(const struct history *h, size_t s)
{
    const struct rmap_object *object = &h->scene->object[h->p->segment.object[s]];
    int medium = h->p->segment.medium[s];
    if (object->medium_front >= 0 && object->medium_back >= 0 &&
        object->medium_front != object->medium_back)
        return medium == object->medium_front ? 0 : medium == object->medium_back ? 1 : -1;
    const float *at = h->p->segment.position + 3 * s;
    const float *from = s == h->first_step ? h->p->ray.start + 3 * h->ray : at - 3;
    const int16_t *n = h->p->segment.normal + 3 * s;
    double along = 0, onward = 0;
    for (int k = 0; k < 3; k++)
        along += ((double)at[k] - (double)from[k]) * n[k];
    if (along != 0)
        return along > 0;
    if (s + 1 == h->first_step + h->n_step)
        return 0;
    for (int k = 0; k < 3; k++)
        onward += ((double)at[3 + k] - (double)at[k]) * n[k];
    return h->p->segment.event[s] & (1 | 2 | 16) ? onward < 0 : onward > 0;
}

static void make_surface(struct maker *m, struct formula *f, const struct comparison *c)
{
    static const struct {
        const char *text;
        unsigned surfaces;
    } row[] = {
        {"polished", 1},
        {"black", 2},
        {"white", 8},
        {"*e*", 1 | 4 | 8 | 16},
        {"reflectance < 0.1", 2 | 4},
        {"reflect_diffuse >= 0.2", 8 | 16},
        {"absorb != 0", 2 | 8 | 16},
    };
    int name = roll(&m->dice, COUNT(row));
    int event = roll(&m->dice, 2 * COUNT(event_names)) - COUNT(event_names);
    write_text(f, "surface(%s%s%s)", row[name].text, event >= 0 ? ", " : "",
               event >= 0 ? event_names[event].name : "");
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        int n = 0;
        for (size_t s = h->first_step; s < h->first_step + h->n_step; s++) {
            if (h->p->segment.object[s] < 0 ||
                (event >= 0 && !(h->p->segment.event[s] & event_names[event].bits)))
                continue;
            const struct rmap_object *object = &h->scene->object[h->p->segment.object[s]];
            unsigned front = row[name].surfaces >> object->surface_front & 1;
            unsigned back = row[name].surfaces >> object->surface_back & 1;
            int side = front == back ? 0 : side_met(h, s);
            n += side == 0 ? (int)front : side == 1 ? (int)back : 0;
        }
        f->truth[i] = compares(c, n);
    }
}

static void make_event_or_medium(struct maker *m, struct formula *f, const struct comparison *c)
{
    static const char *const medium_name[] = {"air", "glass", "ink"};
    int event = roll(&m->dice, COUNT(event_names)), medium = roll(&m->dice, 6);
    if (medium < 3)
        write_text(f, "medium(%s)", medium_name[medium]);
    else
        write_text(f, "event(%s)", event_names[event].name);
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        int n = 0;
        for (size_t s = h->first_step; s < h->first_step + h->n_step; s++)
            if (medium < 3 ? h->p->segment.medium[s] == medium
                           : (h->p->segment.event[s] & event_names[event].bits) != 0)
                n++;
        f->truth[i] = compares(c, n);
    }
}

static void make_source_or_ending(struct maker *m, struct formula *f, const struct comparison *c)
{
    static const char *const stop_name[] = {"absorbed", "left", "limit", "error"};
    int choice = roll(&m->dice, 3), stop = roll(&m->dice, 4);
    int name = roll(&m->dice, COUNT(object_names));
    if (choice == 0)
        write_text(f, "source(%s)", stop % 2 ? "sun" : "lamp");
    else if (choice == 1)
        write_text(f, "ended(%s)", stop_name[stop]);
    else
        write_text(f, "ended(%s, %s)", stop_name[stop],
                   name == 0 ? "ink" : object_names[name].name);
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        bool is = choice == 0 ? h->p->ray.source[i] == stop % 2 : h->p->ray.stop[i] == stop;
        if (choice == 2 && h->n_step == 0) {
            is = false;
        } else if (choice == 2) {
            size_t last = h->first_step + h->n_step - 1;
            int object = h->p->segment.object[last];
            unsigned media = name == 0                                   ? 4
                             : !strcmp(object_names[name].name, "*")     ? 7
                             : !strcmp(object_names[name].name, "?????") ? 2
                                                                         : 0;
            is = is && (object >= 0 ? name != 0 && is_object(object_names[name].objects, object)
                                    : (media >> h->p->segment.medium[last] & 1));
        }
        f->truth[i] = compares(c, is);
    }
}

static void make_number(struct maker *m, struct formula *f)
{
    static const char *const name[] = {"segments",    "bounces", "wavelength",  "flux",
                                       "path_length", "ray",     "optical_path"};
    static const double low[] = {0, 0, 400, 0, 0, 1000, 0};
    static const double step[] = {1, 1, 50, 0.25, 1, 30, 1};
    static const char *const unit[] = {"", "", " nm", " W", "mm", "", ""};
    int which = roll(&m->dice, COUNT(name));
    struct comparison c = roll_comparison(&m->dice, low[which], step[which], 8);
    write_text(f, "%s", name[which]);
    write_comparison(f, &c, unit[which]);
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        int bounces = 0;
        for (size_t s = h->first_step; s < h->first_step + h->n_step; s++) {
            char letter = rmap_event_letter(h->p->segment.event[s]);
            bounces += letter && strchr("OFSIRTDd", letter) != NULL;
        }
        const double value[] = {
            (double)h->n_step,        bounces,
            h->p->ray.wavelength[i],  h->p->ray.weight[i] * flux_per_weight[h->p->ray.source[i]],
            h->p->ray.path_length[i], (double)h->p->ray.id[i],
            h->p->ray.optical_path[i]};
        f->truth[i] = compares(&c, value[which]);
    }
}

static double its_value(const struct history *h, size_t row, int which)
{
    const struct rmap_detector *d = &h->scene->detector[h->p->registration.detector[row]];
    const float *v = h->p->registration.direction + 3 * row;
    if (which == 0) { /* angle, by the half-angle formula */
        double sign = h->p->registration.detector[row] == 2 ? 1 : -1;
        double length = sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] +
                             (double)v[2] * (double)v[2]);
        double cosine =
            sign *
            ((double)v[0] * d->axis.x + (double)v[1] * d->axis.y + (double)v[2] * d->axis.z) /
            length;
        return acos(fmax(-1, fmin(1, cosine))) * 180 / RMAP_PI;
    }
    if (which == 3)
        return h->p->registration.optical_path[row] * 1e-3 / 299792458.0 * 1e12; /* ps */
    double r = h->p->registration.relative[2 * row + (size_t)which - 1] / 65535.0;
    if (h->p->registration.detector[row] == 2)
        return r * (which == 1 ? 180 : 360);
    return (r - 0.5) * d->size[which - 1];
}

static const struct {
    const char *name;
    unsigned detectors;
} detector_names[] = {{"sensor", 1}, {"screen", 2}, {"far", 4}, {"s*", 3}};

/* Bounds between the values that occur, so that rounding decides nothing. */
static void make_registered(struct maker *m, struct formula *f, const struct comparison *c)
{
    static const char *const its_name[] = {"angle", "x", "y", "time"};
    int name = roll(&m->dice, COUNT(detector_names)), crossed = roll(&m->dice, 2);
    int which = roll(&m->dice, 4), region = roll(&m->dice, 4);
    double x0 = 0.1 + 0.2 * roll(&m->dice, 4), y0 = 0.1 + 0.2 * roll(&m->dice, 4);
    double x1 = x0 + 0.4, y1 = y0 + 0.4;
    int i0 = roll(&m->dice, 4), j0 = roll(&m->dice, 4);
    struct comparison where = {roll(&m->dice, 4) + 2, 0, 0};
    where.v = which == 0   ? 20.0 + 10.0 * roll(&m->dice, 10)
              : which == 3 ? 1.7 + 3.3 * roll(&m->dice, 5)
                           : -1.0 + 0.7 * roll(&m->dice, 5) + 0.123;
    bool has_where = roll(&m->dice, 2);
    write_text(f, "%s(%s", crossed ? "crossed" : "registered", detector_names[name].name);
    if (region == 0)
        write_text(f, ", rect(%.17g, %.17g, %.17g, %.17g, rel)", x0, y0, x1, y1);
    else if (region == 1)
        write_text(f, ", cells(%d..%d, %d)", i0, i0 + 2, j0);
    else if (region == 2)
        write_text(f, ", polygon(%.17g,%.17g, %.17g,%.17g, %.17g,%.17g, %.17g,%.17g, rel)", x0, y0,
                   x1, y0, x1, y1, x0, y1);
    if (has_where) {
        write_text(f, " where %s", its_name[which]);
        write_comparison(f, &where, which == 3 ? "ps" : "");
    }
    write_text(f, ")");
    for (int i = 0; i < N_RAY; i++) {
        const struct history *h = &m->history[i];
        int n = 0;
        for (size_t r = h->first_seen; r < h->first_seen + h->n_seen; r++) {
            double x = h->p->registration.relative[2 * r] / 65535.0;
            double y = h->p->registration.relative[2 * r + 1] / 65535.0;
            const uint16_t *cell = h->p->registration.cell + 2 * r;
            bool in_box = x >= x0 && x <= x1 && y >= y0 && y <= y1;
            bool in_cells = cell[0] >= i0 && cell[0] <= i0 + 2 && cell[1] == j0;
            if ((detector_names[name].detectors >> h->p->registration.detector[r] & 1) &&
                (crossed || h->p->registration.registered[r]) &&
                (region == 3 || (region == 1 ? in_cells : in_box)) &&
                (!has_where || compares(&where, its_value(h, r, which))))
                n++;
        }
        f->truth[i] = compares(c, n);
    }
}

static void make_leaf(struct maker *m, struct formula *f)
{
    struct comparison c = {5, 1, 0};
    bool compared = roll(&m->dice, 3) == 0;
    if (compared)
        c = roll_comparison(&m->dice, -1, 1, 5);
    switch (roll(&m->dice, 7)) {
    case 0:
    case 1:
        make_hit(m, f, &c);
        break;
    case 2:
        make_surface(m, f, &c);
        break;
    case 3:
        make_event_or_medium(m, f, &c);
        break;
    case 4:
        make_source_or_ending(m, f, &c);
        break;
    case 5:
        make_number(m, f);
        return;
    default:
        make_registered(m, f, &c);
        break;
    }
    if (compared)
        write_comparison(f, &c, "");
}

/* Everything above a leaf stands in parentheses; precedence is tested elsewhere. */
static void make_formula(struct maker *m, struct formula *f, int depth)
{
    int choice = depth > 0 ? roll(&m->dice, 4) : 3;
    if (choice == 3) {
        make_leaf(m, f);
        return;
    }
    if (choice == 2) {
        write_text(f, "not (");
        make_formula(m, f, depth - 1);
        for (int i = 0; i < N_RAY; i++)
            f->truth[i] = !f->truth[i];
        write_text(f, ")");
        return;
    }
    bool own[N_RAY];
    int n = 2 + roll(&m->dice, 3);
    for (int k = 0; k < n; k++) {
        write_text(f, "%s(", k == 0 ? "" : choice ? " and " : " or ");
        make_formula(m, f, depth - 1);
        write_text(f, ")");
        for (int i = 0; i < N_RAY; i++)
            own[i] = k == 0 ? f->truth[i] : choice ? own[i] && f->truth[i] : own[i] || f->truth[i];
    }
    memcpy(f->truth, own, sizeof own);
}

static void read_histories(struct maker *m, const struct rmap_portion *portion,
                           const struct rmap_scene *scene)
{
    size_t step = 0, seen = 0;
    for (size_t i = 0; i < N_RAY; i++) {
        m->history[i] = (struct history){portion,
                                         scene,
                                         i,
                                         step,
                                         portion->ray.segment_count[i],
                                         seen,
                                         portion->ray.registration_count[i]};
        step += portion->ray.segment_count[i];
        seen += portion->ray.registration_count[i];
    }
}

/* From discrete columns alone an outcome may stay open, but never be wrong. */
static void check_bounds(const struct formula *f, const struct rmap_criterion *criterion,
                         const struct rmap_portion *portion, size_t *n_open)
{
    struct rmap_portion part = *portion;
    struct rmap_evaluator evaluator = {0};
    uint8_t outcome[N_RAY];
    const struct rmap_criterion_input input = {.portion = &part, .columns = RMAP_COLUMNS_DISCRETE};
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (!(RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c)))
            *rmap_portion_column_address(&part, (enum rmap_column)c) = NULL;
    assert_int_equal(rmap_criterion_decide(criterion, &input, &evaluator, outcome, NULL), RMAP_OK);
    rmap_evaluator_fini(&evaluator);
    bool is_discrete = !(rmap_criterion_columns(criterion) & ~RMAP_COLUMNS_DISCRETE);
    for (int i = 0; i < N_RAY; i++) {
        if (outcome[i] == RMAP_OUTCOME_OPEN && !is_discrete)
            ++*n_open;
        else if (outcome[i] != (f->truth[i] ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO))
            fail_msg("%s\nray row %d: verdict %d, expected %d", f->text, i, outcome[i],
                     f->truth[i]);
    }
}

/* Also: a portion that holds a match must not be skipped by its summary. */
static void check_formula(const struct formula *f, const struct rmap_scene *scene,
                          const struct rmap_portion *portion,
                          const struct rmap_portion_summary *summary, size_t *n_match,
                          size_t *n_open)
{
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[N_RAY];
    bool any = false;
    if (rmap_criterion_compile(f->text, scene, &criterion, &err) != RMAP_OK)
        fail_msg("%s\n%s", f->text, err.text);
    if (rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err) != RMAP_OK)
        fail_msg("%s\n%s", f->text, err.text);
    for (int i = 0; i < N_RAY; i++) {
        if (match[i] != f->truth[i])
            fail_msg("%s\nray row %d: %d, expected %d", f->text, i, match[i], f->truth[i]);
        any |= f->truth[i];
        *n_match += f->truth[i];
    }
    if (any && !rmap_criterion_may_match(criterion, summary))
        fail_msg("%s\nskips a portion that has matches", f->text);
    check_bounds(f, criterion, portion, n_open);
    rmap_criterion_destroy(criterion);
}

static void test_random(void **state)
{
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    size_t n_match = 0, n_open = 0;
    struct formula *f = rmap_alloc(1, sizeof *f);
    struct maker *m = rmap_alloc(1, sizeof *m);
    for (uint64_t seed = 0; seed < N_CRITERION / 50; seed++) {
        struct rmap_portion_summary summary;
        m->dice = (struct dice){seed, 0};
        struct rmap_portion *portion = roll_portion(&m->dice);
        rmap_portion_summarise(portion, &summary);
        read_histories(m, portion, &t.scene);
        for (int k = 0; k < 50; k++) {
            f->text[0] = 0;
            make_formula(m, f, k % 4);
            check_formula(f, &t.scene, portion, &summary, &n_match, &n_open);
        }
        rmap_portion_destroy(portion);
    }
    /* The criteria must not be all trivial. */
    assert_in_range(n_match, N_CRITERION * N_RAY / 5, N_CRITERION * N_RAY / 5 * 4);
    assert_in_range(n_open, N_CRITERION * N_RAY / 20, N_CRITERION * N_RAY / 2);
    rmap_free(m);
    rmap_free(f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Small portions are often skipped; none that is may hold a match. */
static void test_random_skipping(void **state)
{
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    size_t n_skipped = 0;
    struct formula *f = rmap_alloc(1, sizeof *f);
    struct maker *m = rmap_alloc(1, sizeof *m);
    for (uint64_t seed = 0; seed < 60; seed++) {
        m->dice = (struct dice){1000 + seed, 0};
        struct rmap_portion *portion = roll_portion(&m->dice), *one = NULL;
        read_histories(m, portion, &t.scene);
        for (int k = 0; k < 40; k++) {
            struct rmap_criterion *criterion = NULL;
            struct rmap_portion_summary summary;
            size_t ray = (size_t)roll(&m->dice, N_RAY);
            const struct history *h = &m->history[ray];
            f->text[0] = 0;
            make_formula(m, f, k % 3);
            assert_int_equal(rmap_portion_create(1, 3, &one, NULL), RMAP_OK);
            assert_int_equal(
                rmap_portion_append_ray(one, portion, ray, h->first_step, h->first_seen, NULL),
                RMAP_OK);
            rmap_portion_summarise(one, &summary);
            assert_int_equal(rmap_criterion_compile(f->text, &t.scene, &criterion, NULL), RMAP_OK);
            bool may = rmap_criterion_may_match(criterion, &summary);
            if (f->truth[ray] && !may)
                fail_msg("%s\nskips ray row %zu of seed %d", f->text, ray, (int)seed);
            n_skipped += !may;
            rmap_criterion_destroy(criterion);
            rmap_portion_destroy(one);
        }
        rmap_portion_destroy(portion);
    }
    assert_true(n_skipped > 300);
    rmap_free(m);
    rmap_free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_random_skipping),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
