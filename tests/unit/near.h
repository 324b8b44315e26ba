/* SPDX-License-Identifier: MIT
 *
 * Comparisons of numbers that print both values. Include after cmocka.h.
 */
#ifndef NEAR_H
#define NEAR_H

#include <math.h>

#define assert_near(value, expected, tolerance)                                                    \
    assert_near_at((value), (expected), (tolerance), #value, __FILE__, __LINE__)

static inline void assert_near_at(double value, double expected, double tolerance, const char *text,
                                  const char *file, int line)
{
    if (fabs(value - expected) <= tolerance)
        return;
    print_error("%s = %.17g, expected %.17g +- %g (off by %g)\n", text, value, expected, tolerance,
                value - expected);
    _fail(file, line);
}

/* Observed mean of n independent draws against its expectation and the variance of one draw:
 * |z| <= 4 (one test in 16,000 fails by chance; the seeds here are fixed). */
#define assert_mean(sum, n, expected, variance)                                                    \
    assert_near((sum) / (double)(n), (expected), 4.0 * sqrt((variance) / (double)(n)))

#endif
