/* SPDX-License-Identifier: MIT
 *
 * Scatter models: one table, which drives the scene file, criteria and reports, and their numbers.
 *
 * A model is asked in the frame of the side that light meets: z is the side's normal towards the
 * light; directions are those of travel, so light arrives with z <= 0, is reflected to z > 0 and
 * passes to z < 0. A BSDF is per unit of arriving light, in 1/sr. beta is the tangential part of a
 * direction, beta0 that of the specular one; x = |beta - beta0|. Light beyond the horizon is cut,
 * neither folded nor renormalised.
 */
#ifndef RMAP_SCATTER_H
#define RMAP_SCATTER_H

#include "base/rng.h"
#include "base/status.h"
#include "base/vec.h"
#include "optics/spectrum.h"

/* Columns: number in maps, which it keeps; symbol, `model` in a scene file, keys beside `model`,
 * whether it is reciprocal.
 *
 *   LAMBERT        the same radiance in all directions
 *   GAUSSIAN       exp(-x^2 / (2 sigma^2))
 *   COSINE         power of the cosine of the angle to the specular direction
 *   ABG            A / (B + x^g) (Pfisterer, Approximated Scatter Models for Stray Light Analysis,
 *                  Optics & Photonics News 22 (2011) 16)
 *   HARVEY         b0 (1 + (x/l)^2)^(s/2) (Harvey, Light-scattering characteristics of optical
 *                  surfaces, Univ. of Arizona (1976)); by roughness: docs/physics.md
 *   K_CORRELATION  Rayleigh-Rice scatter of a K-correlation power spectrum (Dittman, Proc. SPIE
 *                  6291 (2006) 62910R, doi:10.1117/12.678320)
 *   GGX, BECKMANN  facets (Walter et al. 2007, doi:10.2312/EGWR/EGSR07/195-206), those that light
 *                  sees (Heitz 2018, JCGT 7 (4) 1)
 *   UNIFIED        spike, facet lobe, straight back and Lambert (Levin & Moisan 1996,
 *                  doi:10.1109/NSSMIC.1996.591410; facets as Geant4 draws them)
 *   RETRO          a Gaussian about the way back
 *   TABLE, KLEMS   measured: table.h
 *   CONTAMINATION  particles: dust.h
 *   OREN_NAYAR     a relief of Lambert's facets, with what meets several of them (EON: Portsmouth,
 *                  Kutz & Hill 2025, JCGT 14 (1) 116)
 *   SLOPE_ERROR    facets of slopes that are normal, or a pillbox: even within a circle (Wendelin,
 *                  Dobos & Lewandowski 2013, SolTrace, NREL/TP-5500-59163) */
#define RMAP_SCATTER_TABLE(X)                                                                      \
    X(0, LAMBERT, "lambert", "tis", true)                                                          \
    X(1, GAUSSIAN, "gaussian", "sigma tis", true)                                                  \
    X(2, COSINE, "cosine", "power tis", true)                                                      \
    X(3, ABG, "abg", "A B g", true)                                                                \
    X(4, HARVEY, "harvey", "b0 l s reference roughness correlation", true)                         \
    X(5, K_CORRELATION, "k_correlation", "roughness correlation s reference", true)                \
    X(6, GGX, "ggx", "alpha", true)                                                                \
    X(7, BECKMANN, "beckmann", "alpha", true)                                                      \
    X(8, UNIFIED, "unified", "sigma_alpha spike lobe back", false)                                 \
    X(9, RETRO, "retro", "sigma tis", true)                                                        \
    X(10, TABLE, "table", "file relative", false)                                                  \
    X(11, KLEMS, "klems", "file band", false)                                                      \
    X(12, CONTAMINATION, "contamination", "level slope area n k", false)                           \
    X(13, OREN_NAYAR, "oren_nayar", "r tis", true)                                                 \
    X(14, SLOPE_ERROR, "slope_error", "gaussian pillbox", true)

enum rmap_scatter_model {
#define RMAP_SCATTER_ENUM(number, symbol, name, keys, reciprocal) RMAP_SCATTER_##symbol,
    RMAP_SCATTER_TABLE(RMAP_SCATTER_ENUM)
#undef RMAP_SCATTER_ENUM
        RMAP_SCATTER_COUNT
};
#define RMAP_SCATTER_NUMBER(number, symbol, name, keys, reciprocal)                                \
    _Static_assert(RMAP_SCATTER_##symbol == (number), "rows stand by number: " name);
RMAP_SCATTER_TABLE(RMAP_SCATTER_NUMBER)
#undef RMAP_SCATTER_NUMBER

struct rmap_scatter_table;
struct rmap_scatter_dust;

struct rmap_scatter_name {
    const char *name, *keys;
    bool reciprocal;
};

static const struct rmap_scatter_name rmap_scatter_name[] = {
#define RMAP_SCATTER_ROW(number, symbol, name, keys, reciprocal) {name, keys, reciprocal},
    RMAP_SCATTER_TABLE(RMAP_SCATTER_ROW)
#undef RMAP_SCATTER_ROW
};

/* What `shape` holds, by model. */
enum {
    RMAP_SHAPE_SIGMA = 0, /* GAUSSIAN, RETRO: of beta; UNIFIED: of facets, radians */
    RMAP_SHAPE_POWER = 0, /* COSINE */
    RMAP_SHAPE_B = 0,
    RMAP_SHAPE_G, /* ABG */
    RMAP_SHAPE_L = 0,
    RMAP_SHAPE_S,         /* HARVEY, K_CORRELATION; by roughness: l in vacuum */
    RMAP_SHAPE_ROUGHNESS, /* the same: in wavelengths in vacuum */
    RMAP_SHAPE_ALPHA_X = 0,
    RMAP_SHAPE_ALPHA_Y, /* GGX, BECKMANN, SLOPE_ERROR */
    RMAP_SHAPE_PILLBOX, /* SLOPE_ERROR: 1, or 0: normal */
    RMAP_SHAPE_SPIKE = 1,
    RMAP_SHAPE_LOBE,
    RMAP_SHAPE_BACK,          /* UNIFIED */
    RMAP_SHAPE_SCATTERED = 0, /* CONTAMINATION: optical thickness of one crossing */
    RMAP_SHAPE_EXTINCT,
    RMAP_SHAPE_R = 0, /* OREN_NAYAR: roughness, and how much comes of several facets */
    RMAP_SHAPE_SEVERAL,
    RMAP_SHAPE_MAX = 4
};

/* What `derived` holds, by model. */
enum {
    RMAP_DERIVED_FARTHEST = 0, /* COSINE: sine of the angle from the axis beyond which there is less
                                  than 1e-13 of the lobe */
    RMAP_DERIVED_KNEE = 0,     /* ABG: B^(1/g), and that to the power 2 - g */
    RMAP_DERIVED_TAIL,
    RMAP_DERIVED_MAX
};

/* Totals over the angle of incidence stand at cos = (k / RMAP_TOTAL_STEPS)^2. */
enum { RMAP_TOTAL_STEPS = 128 };

/* Integrals of the shape times the cosine, for light that comes in one medium and, where the lobe
 * passes, goes on in another. */
struct rmap_scatter_totals {
    int32_t near, far; /* -1: any */
    int n_channel;
    double *at; /* [reflected, passing where it refracts][n_channel][RMAP_TOTAL_STEPS + 1] */
};

/* A lobe of a surface. */
struct rmap_scatter {
    enum rmap_scatter_model model;
    int32_t of_reflected, of_transmitted; /* surface whose light it scatters; -1: none */
    bool refracts;                        /* its light, or some of it, goes on beyond the side */
    bool by_wavelength;                   /* its shape differs between channels */
    bool by_roughness;                    /* its amount follows from roughness, index and angle */
    double amount[RMAP_CHANNEL_MAX];      /* BSDF = amount x shape; by roughness and of facets: 1 */
    double shape[RMAP_SHAPE_MAX][RMAP_CHANNEL_MAX];
    double derived[RMAP_DERIVED_MAX][RMAP_CHANNEL_MAX]; /* rmap_scatter_derive; in no map */
    struct rmap_scatter_totals *totals;                 /* [n_totals], owned */
    struct rmap_scatter_table *table;                   /* TABLE, KLEMS; owned */
    struct rmap_scatter_dust *dust;                     /* CONTAMINATION; owned */
    int32_t next; /* 1 + row of another model of the same light; 0: none */
    size_t n_totals;
};

static inline bool rmap_scatter_is_facets(const struct rmap_scatter *scatter)
{
    return scatter->model == RMAP_SCATTER_GGX || scatter->model == RMAP_SCATTER_BECKMANN ||
           scatter->model == RMAP_SCATTER_SLOPE_ERROR || scatter->model == RMAP_SCATTER_UNIFIED;
}

static inline bool rmap_scatter_is_table(const struct rmap_scatter *scatter)
{
    return scatter->model == RMAP_SCATTER_TABLE || scatter->model == RMAP_SCATTER_KLEMS;
}

/* Its x and y are told apart. */
static inline bool rmap_scatter_is_anisotropic(const struct rmap_scatter *scatter, int n_channel)
{
    bool differs = false;
    for (int i = 0; i < n_channel; i++)
        differs = differs ||
                  scatter->shape[RMAP_SHAPE_ALPHA_X][i] != scatter->shape[RMAP_SHAPE_ALPHA_Y][i];
    return rmap_scatter_is_table(scatter) || (differs && (scatter->model == RMAP_SCATTER_GGX ||
                                                          scatter->model == RMAP_SCATTER_BECKMANN));
}

/* Does the index of the media shape it? */
static inline bool rmap_scatter_uses_index(const struct rmap_scatter *scatter)
{
    return scatter->refracts || scatter->by_roughness || rmap_scatter_is_facets(scatter);
}

/* Light at a side. */
struct rmap_scattering {
    const struct rmap_scatter *scatter;
    int channel;
    bool passes;         /* the lobe of transmitted light is asked for */
    bool front;          /* light comes from the front of the object: tables */
    double n1, n2;       /* index before and beyond */
    struct rmap_vec3 in; /* unit, z <= 0 */
    double total;        /* where it is asked for: of rmap_scatter_total */
    /* CONTAMINATION: do particles lie beyond the boundary, not before it? Of the light that they
     * take, what is to go on, or to be reflected, and what they send back. */
    bool beyond;
    double ahead, back;
};

/* Lobes (all but facets), lobe.c. */

/* Fills the numbers that follow from the shape: before the first draw, and after a map's shape. */
void rmap_scatter_derive(struct rmap_scatter *scatter, int n_channel);

/* BSDF / amount towards `out`, a unit vector. */
double rmap_lobe_shape(const struct rmap_scattering *at, struct rmap_vec3 out);

/* Integral of shape times |cos| over the hemisphere, by quadrature; good to 1e-8 of it where lobes
 * are wider than 1e-5. */
double rmap_lobe_total(const struct rmap_scattering *at);

/* Draws until a direction lies above the horizon; then the specular one is taken. Fewer than one
 * ray in 1e12 comes so far. */
enum { RMAP_TRIES_MAX = 1000 };

/* A direction with the density shape times |cos| over that integral. Numbers are those of the
 * slots RMAP_RNG_LOBE and on. */
struct rmap_vec3 rmap_lobe_draw(const struct rmap_scattering *at, const struct rmap_draw *draw);

/* Fills totals for a pair of media, if they are not there. index: [channels]. */
enum rmap_status rmap_scatter_tabulate(struct rmap_scatter *scatter, int n_channel, int32_t near,
                                       int32_t far, const double *n1, const double *n2,
                                       struct rmap_error *err) RMAP_MUST_USE;
/* rmap_lobe_total, by the table where there is one. */
double rmap_scatter_total(const struct rmap_scattering *at, int32_t near, int32_t far);

void rmap_scatter_fini(struct rmap_scatter *scatter);

/* OREN_NAYAR of a roughness and its facets' albedo: the amount and RMAP_SHAPE_SEVERAL. */
void rmap_rough_diffuse(double r, double albedo, double *amount_ret, double *several_ret);

/* Roughness that is small against the wavelength: share of what a boundary reflects, or lets pass,
 * that is scattered; roughness in wavelengths in vacuum (Davies 1954, doi:10.1049/pi-3.1954.0025;
 * the refracted part by the difference of optical paths). */
double rmap_rough_share(double roughness, bool passes, double n1, double cos_1, double n2,
                        double cos_2);

/* Facets, facet.c. */

/* A facet's normal (towards the light): by the area that light sees, but of UNIFIED by angle, one
 * that reflects to z > 0 and, where the surface refracts, refracts to z < 0. */
struct rmap_vec3 rmap_facet_draw(const struct rmap_scattering *at, const struct rmap_draw *draw);

/* Share of the light from a facet to `out` that no other facet is in the way of. */
double rmap_facet_unhindered(const struct rmap_scattering *at, struct rmap_vec3 out);

/* BSDF towards `out` over the share of the light that the facet reflects (out.z > 0) or refracts,
 * which is to be taken at *cos_ret, the cosine of incidence on it; 0: no facet sends light there.
 * UNIFIED: over the share of its facet lobe, too; `total` is that of rmap_scatter_total. */
double rmap_facet_bsdf(const struct rmap_scattering *at, struct rmap_vec3 out, double *cos_ret);

/* Directions by a facet of this normal; refracted: false where all is reflected. */
struct rmap_vec3 rmap_facet_reflected(struct rmap_vec3 in, struct rmap_vec3 normal);
bool rmap_facet_refracted(const struct rmap_scattering *at, struct rmap_vec3 normal,
                          struct rmap_vec3 *out);

/* UNIFIED: the integral of exp(-a^2 / (2 sigma^2)) over the facets that rmap_facet_draw draws, of
 * each direction in[n] in the place of `at->in`, into fit[n]. */
void rmap_facet_fit(const struct rmap_scattering *at, size_t n, const struct rmap_vec3 *in,
                    double *fit);

/* Integral over facets: what is reflected, what passes, and what meets another facet, of light
 * whose facets reflect share[0], and let pass share[1], at a cosine of incidence. */
void rmap_facet_total(const struct rmap_scattering *at,
                      void (*shares)(const void *self, double cosine, double share[2]),
                      const void *self, double total[3]);

#endif
