/* SPDX-License-Identifier: MIT
 *
 * Fresnel reflectances (Born & Wolf, Principles of Optics, 7th ed., 1.5.2 and 14.2; metal with
 * complex index n + i k).
 */
#include "optics/fresnel.h"

#include <math.h>

/* a^2 + b^2 and a of the refracted wave, a - i b = sqrt(m^2 - sin^2), m = (n + i k) / n1; then
 * Rs and Rp = Rs x tangent factor (Born & Wolf 14.2, eqs. 5 to 8 in this notation). */
double rmap_fresnel_metal(double n1, double n, double k, double cos_i)
{
    double m_n = n / n1, m_k = k / n1;
    double sin2 = 1.0 - cos_i * cos_i;
    double real = m_n * m_n - m_k * m_k - sin2;
    double ab2 = hypot(real, 2.0 * m_n * m_k);
    double a = sqrt(fmax(0.0, 0.5 * (ab2 + real)));
    double s_sum = ab2 + cos_i * cos_i, s_mix = 2.0 * a * cos_i;
    double p_sum = ab2 * cos_i * cos_i + sin2 * sin2, p_mix = s_mix * sin2;
    if (s_sum + s_mix <= 0.0 || p_sum + p_mix <= 0.0)
        return 1.0; /* grazing along an index of the same value */
    double rs = (s_sum - s_mix) / (s_sum + s_mix);
    return 0.5 * rs * (1.0 + (p_sum - p_mix) / (p_sum + p_mix));
}

double rmap_fresnel_metal_portable(double n1, double n, double k, double cos_i)
{
    double m_n = n / n1, m_k = k / n1, sin2 = 1.0 - cos_i * cos_i;
    double real = m_n * m_n - m_k * m_k - sin2, imaginary = 2.0 * m_n * m_k;
    double ab2 = sqrt(real * real + imaginary * imaginary), half = 0.5 * (ab2 + real);
    double a = sqrt(half > 0.0 ? half : 0.0);
    double s_sum = ab2 + cos_i * cos_i, s_mix = 2.0 * a * cos_i;
    double p_sum = ab2 * cos_i * cos_i + sin2 * sin2, p_mix = s_mix * sin2;
    if (s_sum + s_mix <= 0.0 || p_sum + p_mix <= 0.0)
        return 1.0;
    double rs = (s_sum - s_mix) / (s_sum + s_mix);
    return 0.5 * rs * (1.0 + (p_sum - p_mix) / (p_sum + p_mix));
}
