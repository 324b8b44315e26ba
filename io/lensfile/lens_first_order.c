/* SPDX-License-Identifier: MIT
 *
 * y-nu trace of a prescription, W. T. Welford, Aberrations of Optical Systems (1986), sections 3.3
 * to 3.6: refraction n'u' = n u - y c (n' - n), transfer y' = y + d u; a mirror turns the sign of
 * the index behind it, as files turn that of their thicknesses. src/scene/paraxial.h has the same
 * of a scene's lens, which has no mirrors and no order.
 */
#include <math.h>

#include "io/lensfile/lens_layout.h"

struct ray {
    double y, nu;
};

/* From before surface `from` to behind surface `to`; *n: index there, signed. y is left at `to`. */
static struct ray trace_in(const struct rmap_lens_plan *plan, int axis, struct ray ray, size_t from,
                           size_t to, double *n)
{
    const struct rmap_prescription *lens = plan->lens;
    for (size_t i = from; i <= to; i++) {
        const struct rmap_lens_surface *surface = &lens->surface[i];
        const double index = plan->media.medium[plan->media.behind[i]].index;
        const double after = surface->is_mirror ? -*n : *n < 0 ? -index : index;
        if (i > from)
            ray.y += lens->surface[i - 1].thickness * ray.nu / *n;
        if (!surface->is_break) {
            ray.nu -= ray.y * plan->place[i].vertex[axis] * (after - *n);
            *n = after;
        }
    }
    return ray;
}

static struct ray trace(const struct rmap_lens_plan *plan, struct ray ray, size_t from, size_t to,
                        double *n)
{
    return trace_in(plan, 1, ray, from, to, n);
}

static size_t stop_of(const struct rmap_prescription *lens)
{
    for (size_t i = 1; i + 1 < lens->n_surface; i++)
        if (lens->surface[i].is_stop)
            return i;
    return 1;
}

/* Diameter of the entrance pupil by what the file gives. parallel, tilted: rays (1, 0) and (0, 1)
 * at surface 1, at the stop. */
static double pupil_diameter(const struct rmap_lens_plan *plan, double parallel, double tilted,
                             double last_nu)
{
    const struct rmap_prescription *lens = plan->lens;
    const struct rmap_first_order *o = &plan->order;
    const double value = lens->pupil_value, to_pupil = o->object + o->entrance;
    const double stop = lens->surface[stop_of(lens)].semi;
    double diameter = 0;
    switch (lens->pupil) {
    case RMAP_PUPIL_DIAMETER:
        diameter = value;
        break;
    case RMAP_PUPIL_F_NUMBER:
        diameter = fabs(o->focal_length) / value;
        break;
    case RMAP_PUPIL_WORKING_F_NUMBER:
        diameter = isfinite(o->object) && o->magnification != 0
                       ? 2 * to_pupil * fabs(o->magnification) / (2 * value)
                       : fabs(o->focal_length) / value;
        break;
    case RMAP_PUPIL_OBJECT_NA:
        diameter = value < 1 && isfinite(to_pupil) ? 2 * to_pupil * tan(asin(value)) : 0;
        break;
    case RMAP_PUPIL_IMAGE_NA:
        diameter = value >= 1            ? 0
                   : isfinite(o->object) ? 2 * to_pupil * fabs(o->magnification) * tan(asin(value))
                                         : 2 * tan(asin(value)) / fabs(last_nu);
        break;
    case RMAP_PUPIL_STOP:
        if (stop > 0 && isfinite(o->object))
            diameter = 2 * fabs(stop * to_pupil / (o->object * parallel + tilted));
        else if (stop > 0)
            diameter = 2 * fabs(stop / parallel);
        break;
    }
    return isfinite(diameter) && diameter > 0 ? diameter : 0;
}

void rmap_lens_first_order(struct rmap_lens_plan *plan)
{
    const struct rmap_prescription *lens = plan->lens;
    struct rmap_first_order *o = &plan->order;
    const double before = plan->media.medium[plan->media.behind[0]].index;
    double n = before;
    o->last = lens->n_surface - 2;
    while (o->last > 1 && lens->surface[o->last].is_break)
        o->last--;
    size_t power = o->last; /* dummies before the image are not counted */
    while (power > 1 && (lens->surface[power].is_break ||
                         (!lens->surface[power].is_mirror &&
                          plan->media.behind[power] == plan->media.behind[power - 1])))
        power--;
    const struct ray out = trace(plan, (struct ray){1, 0}, 1, power, &n);
    double n_x = before;
    const struct ray across = trace_in(plan, 0, (struct ray){1, 0}, 1, power, &n_x);
    const bool anamorphic = fabs(across.nu - out.nu) > 1e-9 * fmax(fabs(across.nu), fabs(out.nu));
    o->across[0] = !anamorphic ? (double)NAN : across.nu == 0 ? HUGE_VAL : -fabs(n_x) / across.nu;
    o->across[1] = !anamorphic      ? (double)NAN
                   : across.nu == 0 ? HUGE_VAL
                                    : -across.y / (across.nu / n_x);
    o->focal_length = out.nu == 0 ? HUGE_VAL : -fabs(n) / out.nu;
    o->back_focus = out.nu == 0 ? HUGE_VAL : -out.y / (out.nu / n);
    o->object = lens->surface[0].thickness;
    const size_t stop = stop_of(lens);
    double n_a = before, n_b = before;
    const double a = trace(plan, (struct ray){1, 0}, 1, stop, &n_a).y;
    const double b = trace(plan, (struct ray){0, before}, 1, stop, &n_b).y;
    o->entrance = a == 0 ? HUGE_VAL : b / a;
    if (isfinite(o->object)) { /* n u / n' u' of the axial ray from the object */
        double n_m = before;
        const struct ray image =
            trace(plan, (struct ray){o->object, before}, 1, lens->n_surface - 2, &n_m);
        o->magnification = image.nu == 0 ? 0 : before / image.nu;
    }
    o->entrance_diameter = pupil_diameter(plan, a, b, out.nu);
    if (!(o->entrance_diameter > 0)) { /* as wide as its first surface, or a tenth of its length */
        double widest = 0;
        for (size_t i = 1; i + 1 < lens->n_surface && !(widest > 0); i++)
            widest = lens->surface[i].semi;
        o->entrance_diameter = widest > 0                  ? 2 * widest
                               : isfinite(o->focal_length) ? 0.1 * fabs(o->focal_length)
                                                           : 1;
    }
    o->f_number = fabs(o->focal_length) / o->entrance_diameter;
}

/* Heights of images become angles by the focal length, or heights of objects by the
 * magnification. */
void rmap_lens_field_at(const struct rmap_lens_plan *plan, const struct rmap_lens_field *field,
                        double xy[2])
{
    const struct rmap_first_order *o = &plan->order;
    const double value[2] = {field->x, field->y};
    const bool far = !isfinite(o->object);
    for (int k = 0; k < 2; k++) {
        const double tangent = tan(fmin(fmax(value[k], -89), 89) * RMAP_PI / 180);
        switch (plan->lens->field_kind) {
        case RMAP_FIELD_ANGLE: /* a near object's angle is that of its ray to the pupil */
            xy[k] = far ? tangent : -tangent * (o->object + o->entrance);
            break;
        case RMAP_FIELD_OBJECT_HEIGHT:
            xy[k] = far ? 0 : value[k];
            break;
        case RMAP_FIELD_IMAGE_HEIGHT:
        case RMAP_FIELD_REAL_HEIGHT:
            xy[k] = far                     ? value[k] / o->focal_length
                    : o->magnification != 0 ? value[k] / o->magnification
                                            : 0;
            break;
        }
        if (!isfinite(xy[k]))
            xy[k] = 0;
    }
}
