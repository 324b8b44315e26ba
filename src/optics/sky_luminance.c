/* SPDX-License-Identifier: MIT
 *
 * How bright the sky is over direction.
 */
#include "optics/sky_luminance.h"

#include "base/portable.h"
#include "base/vec.h"

struct rmap_sky_pattern rmap_cie_sky(int kind)
{
    static const struct rmap_sky_pattern sky[RMAP_CIE_SKIES] = {
        {4.0, -0.70, 0.0, -1.0, 0.0},    {4.0, -0.70, 2.0, -1.5, 0.15},
        {1.1, -0.80, 0.0, -1.0, 0.0},    {1.1, -0.80, 2.0, -1.5, 0.15},
        {0.0, -1.00, 0.0, -1.0, 0.0},    {0.0, -1.00, 2.0, -1.5, 0.15},
        {0.0, -1.00, 5.0, -2.5, 0.30},   {0.0, -1.00, 10.0, -3.0, 0.45},
        {-1.0, -0.55, 2.0, -1.5, 0.15},  {-1.0, -0.55, 5.0, -2.5, 0.30},
        {-1.0, -0.55, 10.0, -3.0, 0.45}, {-1.0, -0.32, 10.0, -3.0, 0.45},
        {-1.0, -0.32, 16.0, -3.0, 0.30}, {-1.0, -0.15, 16.0, -3.0, 0.30},
        {-1.0, -0.15, 24.0, -2.8, 0.15}};
    return sky[kind - 1];
}

struct rmap_sky_pattern rmap_perez_sky(double direct, double diffuse, double zenith_deg,
                                       double nearness)
{
    /* a to e of each bin of clearness: 1, times the zenith angle, and both times brightness */
    static const double table[8][5][4] = {{{1.3525, -0.2576, -0.2690, -1.4366},
                                           {-0.7670, 0.0007, 1.2734, -0.1233},
                                           {2.8000, 0.6004, 1.2375, 1.0000},
                                           {1.8734, 0.6297, 0.9738, 0.2809},
                                           {0.0356, -0.1246, -0.5718, 0.9938}},
                                          {{-1.2219, -0.7730, 1.4148, 1.1016},
                                           {-0.2054, 0.0367, -3.9128, 0.9156},
                                           {6.9750, 0.1774, 6.4477, -0.1239},
                                           {-1.5798, -0.5081, -1.7812, 0.1080},
                                           {0.2624, 0.0672, -0.2190, -0.4285}},
                                          {{-1.1000, -0.2515, 0.8952, 0.0156},
                                           {0.2782, -0.1812, -4.5000, 1.1766},
                                           {24.7219, -13.0812, -37.7000, 34.8438},
                                           {-5.0000, 1.5218, 3.9229, -2.6204},
                                           {-0.0156, 0.1597, 0.4199, -0.5562}},
                                          {{-0.5484, -0.6654, -0.2672, 0.7117},
                                           {0.7234, -0.6219, -5.6812, 2.6297},
                                           {33.3389, -18.3000, -62.2500, 52.0781},
                                           {-3.5000, 0.0016, 1.1477, 0.1062},
                                           {0.4659, -0.3296, -0.0876, -0.0329}},
                                          {{-0.6000, -0.3566, -2.5000, 2.3250},
                                           {0.2937, 0.0496, -5.6812, 1.8415},
                                           {21.0000, -4.7656, -21.5906, 7.2492},
                                           {-3.5000, -0.1554, 1.4062, 0.3988},
                                           {0.0032, 0.0766, -0.0656, -0.1294}},
                                          {{-1.0156, -0.3670, 1.0078, 1.4051},
                                           {0.2875, -0.5328, -3.8500, 3.3750},
                                           {14.0000, -0.9999, -7.1406, 7.5469},
                                           {-3.4000, -0.1078, -1.0750, 1.5702},
                                           {-0.0672, 0.4016, 0.3017, -0.4844}},
                                          {{-1.0000, 0.0211, 0.5025, -0.5119},
                                           {-0.3000, 0.1922, 0.7023, -1.6317},
                                           {19.0000, -5.0000, 1.2438, -1.9094},
                                           {-4.0000, 0.0250, 0.3844, 0.2656},
                                           {1.0468, -0.3788, -2.4517, 1.4656}},
                                          {{-1.0500, 0.0289, 0.4260, 0.3590},
                                           {-0.3250, 0.1156, 0.7781, 0.0025},
                                           {31.0625, -14.5000, -46.1148, 55.3750},
                                           {-7.2312, 0.4050, 13.3500, 0.6234},
                                           {1.5000, -0.6426, 1.8564, 0.5636}}};
    static const double above[7] = {1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2};
    const double z = zenith_deg * RMAP_PI / 180.0, cubed = 1.041 * z * z * z,
                 clearness = ((diffuse + direct) / diffuse + cubed) / (1.0 + cubed),
                 /* Kasten and Young 1989, doi:10.1364/AO.28.004735 */
        air = 1.0 / (cos(z) + 0.50572 * pow(96.07995 - zenith_deg, -1.6364)),
                 bright = air * diffuse / (1367.0 * nearness);
    double x[5];
    int bin = 0;
    while (bin < 7 && clearness >= above[bin])
        bin++;
    for (int i = 0; i < 5; i++) {
        const double *of = table[bin][i];
        x[i] = of[0] + of[1] * z + bright * (of[2] + of[3] * z);
    }
    if (bin == 0) {
        const double *c = table[0][2], *d = table[0][3];
        x[2] = exp(pow(bright * (c[0] + c[1] * z), c[2])) - c[3];
        x[3] = -exp(bright * (d[0] + d[1] * z)) + d[2] + bright * d[3];
    }
    return (struct rmap_sky_pattern){x[0], x[1], x[2], x[3], x[4], true};
}

bool rmap_sky_pattern_has_sun(const struct rmap_sky_pattern *sky)
{
    return sky->c != 0.0 || sky->e != 0.0;
}

double rmap_sky_pattern_at(const struct rmap_sky_pattern *sky, double cos_zenith, double cos_sun)
{
    if (!(cos_zenith > 0.0))
        return 0.0;
    const double sine = 1.0 - cos_sun * cos_sun,
                 chi = rmap_portable_angle(cos_sun, sine > 0.0 ? sqrt(sine) : 0.0),
                 gradation = 1.0 + sky->a * rmap_portable_exp(sky->b / cos_zenith),
                 indicatrix =
                     1.0 +
                     sky->c * (rmap_portable_exp(sky->d * chi) -
                               (sky->bare ? 0.0 : rmap_portable_exp(sky->d * 0.5 * RMAP_PI))) +
                     sky->e * cos_sun * cos_sun,
                 product = gradation * indicatrix;
    return product > 0.0 ? product : 0.0;
}
