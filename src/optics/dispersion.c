/* SPDX-License-Identifier: MIT
 *
 * Refractive index over wavelength: Sellmeier's equation, tables, and the built-in glass list.
 */
#include "optics/dispersion.h"

#include <math.h>
#include <strings.h>

double rmap_sellmeier_index(const struct rmap_sellmeier *sellmeier, double wavelength_nm)
{
    double l2 = wavelength_nm * wavelength_nm * 1e-6; /* um^2 */
    double n2 = 1.0;
    for (size_t i = 0; i < sellmeier->n_term; i++) {
        double gap = l2 - sellmeier->c[i];
        if (gap == 0.0)
            return (double)NAN;
        n2 += sellmeier->b[i] * l2 / gap;
    }
    return n2 >= 1.0 && isfinite(n2) ? sqrt(n2) : (double)NAN;
}

#define SCHOTT                                                                                     \
    "SCHOTT optical glass catalogue 2017, relative to air at 20 C, from refractiveindex.info "     \
    "(CC0)"
#define MALITSON_SIO2 "Malitson 1965, doi:10.1364/JOSA.55.001205, fused silica, 20 C"

/* Three terms; the glass literature prints C squared for SCHOTT glasses and unsquared (um) for
 * the crystals, which SQUARED repeats digit by digit. */
#define TERMS(b1, c1, b2, c2, b3, c3)                                                              \
    {                                                                                              \
        3, {b1, b2, b3},                                                                           \
        {                                                                                          \
            c1, c2, c3                                                                             \
        }                                                                                          \
    }
#define SQUARED(b1, c1, b2, c2, b3, c3) TERMS(b1, (c1) * (c1), b2, (c2) * (c2), b3, (c3) * (c3))
#define SIO2_TERMS                      SQUARED(0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161)

/* clang-format off */
static const struct rmap_glass glass[] = {
    {"Al2O3", SQUARED(1.4313493, 0.0726631, 0.65054713, 0.1193242, 5.3414021, 18.028251), 200, 5000,
     "Malitson & Dodge 1972, synthetic sapphire, ordinary ray, 20 C, from refractiveindex.info (CC0)"},
    {"CaF2", SQUARED(0.5675888, 0.050263605, 0.4710914, 0.1003909, 3.8484723, 34.649040), 230, 9700,
     "Malitson 1963, doi:10.1364/AO.2.001103, 24 C"},
    {"F2", TERMS(1.34533359, 0.00997743871, 0.209073176, 0.0470450767, 0.937357162, 111.886764), 320, 2500, SCHOTT},
    {"F5", TERMS(1.3104463, 0.00958633048, 0.19603426, 0.0457627627, 0.96612977, 115.011883), 320, 2500, SCHOTT},
    {"fused-silica", SIO2_TERMS, 210, 6700, MALITSON_SIO2},
    {"MgF2", SQUARED(0.48755108, 0.04338408, 0.39875031, 0.09461442, 2.3120353, 23.793604), 200, 7000,
     "Dodge 1984, doi:10.1364/AO.23.001980, ordinary ray, 19 C"},
    {"N-BAF10", TERMS(1.5851495, 0.00926681282, 0.143559385, 0.0424489805, 1.08521269, 105.613573), 350, 2500, SCHOTT},
    {"N-BAK4", TERMS(1.28834642, 0.00779980626, 0.132817724, 0.0315631177, 0.945395373, 105.965875), 334, 2500, SCHOTT},
    {"N-BK7", TERMS(1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653), 300, 2500, SCHOTT},
    {"N-FK51A", TERMS(0.971247817, 0.00472301995, 0.216901417, 0.0153575612, 0.904651666, 168.68133), 290, 2500, SCHOTT},
    {"N-LASF9", TERMS(2.00029547, 0.0121426017, 0.298926886, 0.0538736236, 1.80691843, 156.530829), 365, 2500, SCHOTT},
    {"N-SF10", TERMS(1.62153902, 0.0122241457, 0.256287842, 0.0595736775, 1.64447552, 147.468793), 380, 2500, SCHOTT},
    {"N-SF11", TERMS(1.73759695, 0.013188707, 0.313747346, 0.0623068142, 1.89878101, 155.23629), 370, 2500, SCHOTT},
    {"N-SF14", TERMS(1.69022361, 0.0130512113, 0.288870052, 0.061369188, 1.7045187, 149.517689), 365, 2500, SCHOTT},
    {"N-SF2", TERMS(1.47343127, 0.0109019098, 0.163681849, 0.0585683687, 1.36920899, 127.404933), 365, 2500, SCHOTT},
    {"N-SF5", TERMS(1.52481889, 0.011254756, 0.187085527, 0.0588995392, 1.42729015, 129.141675), 370, 2500, SCHOTT},
    {"N-SF6", TERMS(1.77931763, 0.0133714182, 0.338149866, 0.0617533621, 2.08734474, 174.01759), 370, 2500, SCHOTT},
    {"N-SK16", TERMS(1.34317774, 0.00704687339, 0.241144399, 0.0229005, 0.994317969, 92.7508526), 310, 2500, SCHOTT},
    {"N-SK2", TERMS(1.28189012, 0.0072719164, 0.257738258, 0.0242823527, 0.96818604, 110.377773), 310, 2500, SCHOTT},
    {"N-SSK2", TERMS(1.4306027, 0.00823982975, 0.153150554, 0.0333736841, 1.01390904, 106.870822), 326, 2500, SCHOTT},
    {"SiO2", SIO2_TERMS, 210, 6700, MALITSON_SIO2},
};
/* clang-format on */

#define N_GLASS (sizeof glass / sizeof glass[0])

const struct rmap_glass *rmap_glass_find(const char *name)
{
    for (size_t i = 0; i < N_GLASS; i++)
        if (strcasecmp(glass[i].name, name) == 0)
            return &glass[i];
    return NULL;
}

const struct rmap_glass *rmap_glass_at(size_t i)
{
    return i < N_GLASS ? &glass[i] : NULL;
}
