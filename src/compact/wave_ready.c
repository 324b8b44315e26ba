/* SPDX-License-Identifier: MIT
 *
 * Rays that are about to set out in a wave: where they depart, and what each of their legs takes.
 */
#include "base/wide.h"
#include "compact/wave.h"

#if defined(__GNUC__)
static inline uint32_t first_bit(uint32_t x) /* x > 0 */
{
    return (uint32_t)__builtin_ctz(x);
}
#define soon(address) __builtin_prefetch(address, 1)
#else
static inline uint32_t first_bit(uint32_t x)
{
    uint32_t k = 0;
    while (!(x >> k & 1))
        k++;
    return k;
}
#define soon(address) ((void)(address))
#endif

/* What legs follow from, in registers. */
struct legs {
    const int32_t *object, *primitive;
    const uint32_t *event;
    const int16_t *medium;
    const struct rmap_compact_guide *guide;
    const uint16_t *tint;
    size_t n_object, n_medium;
};

/* The leg of a row that starts on the object `from`, has one event and is not the last. No
 * branches: what a ray meets is anybody's guess. True: its triangle is not there. */
static inline bool set_leg(const struct legs *l, size_t row, int32_t from,
                           struct rmap_wave_leg *leg)
{
    size_t object = (uint32_t)l->object[row], primitive = (uint32_t)l->primitive[row];
    size_t medium = (uint16_t)l->medium[row];
    uint32_t event = l->event[row], same = (uint32_t)0 - (l->object[row] == from);
    object = object < l->n_object ? object : l->n_object;
    medium = medium < l->n_medium ? medium : l->n_medium;
    const struct rmap_compact_guide *guide = &l->guide[object];
    uint32_t step = guide->step[first_bit(event | 1u << (RMAP_GUIDE_STEPS - 1))];
    leg->way.corner = guide->corner + guide->stride * primitive;
    leg->object = (uint32_t)object;
    leg->medium = (uint16_t)medium;
    leg->step = (uint16_t)(step + (guide->quadric & same) + l->tint[medium]);
    return primitive >= guide->n_primitive;
}

/* Has any row several events, or one that no guide knows? */
RMAP_WIDE static bool any_odd(const uint32_t *event, size_t n)
{
    uint32_t odd = 0;
    for (size_t i = 0; i < n; i++)
        odd |= (event[i] & (event[i] - 1)) | event[i] >> (RMAP_GUIDE_STEPS - 1);
    return odd != 0;
}

/* With several events, or a triangle that is not there. */
static void set_odd_leg(const struct legs *l, size_t row, int32_t from, struct rmap_wave_leg *leg)
{
    const struct rmap_compact_guide *guide = &l->guide[leg->object];
    bool there = (uint32_t)l->primitive[row] < guide->n_primitive;
    uint32_t own = there && l->object[row] == from ? guide->quadric : 0;
    uint32_t step =
        own + rmap_wave_step(guide, there ? guide->wave : RMAP_WAVE_ALONE, l->event[row]);
    leg->way.corner = there ? leg->way.corner : guide->corner;
    leg->step = (uint16_t)(step | l->tint[leg->medium]);
}

/* Legs of rows [first, end). */
static void set_legs(const struct rmap_retrace *r, size_t first, size_t end,
                     struct rmap_wave_leg *to)
{
    const struct legs l = {.object = r->object,
                           .primitive = r->primitive,
                           .event = r->event,
                           .medium = r->medium,
                           .guide = r->model->guide,
                           .tint = r->model->tint,
                           .n_object = r->model->n_object,
                           .n_medium = r->model->n_medium};
    int32_t from = -1;
    bool odd = any_odd(r->event + first, end - first);
    for (size_t k = first; k < end; k++) {
        odd |= set_leg(&l, k, from, &to[k - first]);
        from = l.object[k];
    }
    for (size_t k = first; odd && k < end; k++)
        if (set_leg(&l, k, k > first ? l.object[k - 1] : -1, &to[k - first]) ||
            any_odd(l.event + k, 1))
            set_odd_leg(&l, k, k > first ? l.object[k - 1] : -1, &to[k - first]);
}

/* Of the ray that is made ready next. */
static void mark_crossings(struct rmap_wave_run *run, struct rmap_wave_leg *leg, size_t n)
{
    const uint32_t *segment = run->r->crossing_segment + run->ready_crossing;
    size_t n_crossing = run->r->registration_count[run->ready];
    for (size_t k = 0; k < n_crossing; k++)
        if (segment[k] < n)
            leg[segment[k]].flags |= RMAP_WAVE_CROSSES;
    run->ready_crossing += n_crossing;
}

/* A quadric of a ray's first leg may be the one that the ray starts on. */
static void set_first(const struct rmap_retrace *r, size_t ray, struct rmap_wave_leg *leg)
{
    uint32_t kind = leg->queue / RMAP_WAVE_TURNS, turn = leg->queue % RMAP_WAVE_TURNS;
    bool own = r->start_object[ray] >= 0 && (uint32_t)r->start_object[ray] == leg->object;
    if (kind != RMAP_WAVE_QUADRIC && kind != RMAP_WAVE_OWN_QUADRIC)
        return;
    kind = own ? RMAP_WAVE_OWN_QUADRIC : RMAP_WAVE_QUADRIC;
    leg->queue = (uint8_t)(kind * RMAP_WAVE_TURNS + turn);
}

/* A shelf for n rays. */
static void open_shelf(struct rmap_wave_run *run, size_t n)
{
    struct rmap_wave *wave = run->wave;
    if (wave->shelf_legs == 0) {
        run->leg = wave->leg + run->ready_row;
        return;
    }
    run->shelf = wave->idle[--wave->n_idle];
    run->leg = wave->leg + run->shelf * wave->shelf_legs;
    wave->on_shelf[run->shelf] = n;
}

/* Rows that will be written here and there, brought nearer in one go: rays go on in no order that
 * a processor foresees. */
RMAP_COPIED void expect(const void *column, size_t row_nbytes, size_t first, size_t end)
{
    enum { LINE = 64 };
    const uint8_t *at = (const uint8_t *)column + first * row_nbytes;
    for (size_t k = 0; column && k < (end - first) * row_nbytes; k += LINE)
        soon(at + k);
}

RMAP_COPIED void expect_rows(const struct rmap_portion *out, size_t first, size_t end)
{
    const struct rmap_segment_columns *segment = &out->segment;
    expect(segment->position, 3 * sizeof *segment->position, first, end);
    expect(segment->normal, 3 * sizeof *segment->normal, first, end);
    expect(out->colour, (size_t)out->n_channel * sizeof *out->colour, first, end);
}

void rmap_wave_ready(struct rmap_wave_run *run)
{
    const struct rmap_retrace *r = run->r;
    size_t row = run->ready_row, end = row;
    size_t last = run->ready + RMAP_WAVE_AHEAD < r->n_ray ? run->ready + RMAP_WAVE_AHEAD : r->n_ray;
    open_shelf(run, last - run->ready);
    struct rmap_wave_leg *leg = run->leg;
    rmap_wave_depart(r, run->ready, last, run->departure);
    for (size_t i = run->ready; i < last; i++)
        end += r->segment_count[i];
    set_legs(r, row, end, leg);
    for (; run->ready < last; run->ready++) {
        size_t n = r->segment_count[run->ready];
        if (n > 0)
            set_first(r, run->ready, leg);
        if (r->crossing_segment)
            mark_crossings(run, leg, n);
        leg += n;
        if (n == 0)
            continue;
        leg[-1].queue &= (uint8_t) ~(RMAP_WAVE_TURNS - 1);
        leg[-1].flags |= RMAP_WAVE_GREY_BACK | RMAP_WAVE_GREY_FRONT;
    }
    run->ready_row = end;
    expect_rows(run->out, row, end);
}
