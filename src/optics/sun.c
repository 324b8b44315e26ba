/* SPDX-License-Identifier: MIT
 *
 * The sun: where it stands, and how bright its disc is from the middle outwards.
 */
#include "optics/sun.h"

#include <math.h>
#include <stddef.h>

#include "base/portable.h"
#include "base/vec.h"
#include "formula/azimuth.h"

/* ---- time ---- */

/* Digits of a number with n of them; -1: there are none. */
static int take(const char **text, int n)
{
    int value = 0;
    for (int i = 0; i < n; i++, (*text)++) {
        if (!(**text >= '0' && **text <= '9'))
            return -1;
        value = 10 * value + (**text - '0');
    }
    return value;
}

static bool skip(const char **text, char c)
{
    const bool there = **text == c;
    *text += there;
    return there;
}

/* Days since 2000-01-01 of the Gregorian calendar, whose years begin in March here. */
static long days_since_2000(int year, int month, int day)
{
    const long y = year - (month < 3), m = (month + 9) % 12;
    return 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 730425;
}

static bool take_zone(const char **text, int *minutes_ahead)
{
    const char sign = **text;
    *minutes_ahead = 0;
    if (skip(text, 'Z'))
        return true;
    if (!skip(text, '+') && !skip(text, '-'))
        return false;
    const int hours = take(text, 2);
    (void)skip(text, ':');
    const int minutes = **text ? take(text, 2) : 0;
    if (hours < 0 || hours > 14 || minutes < 0 || minutes > 59)
        return false;
    *minutes_ahead = (sign == '-' ? -1 : 1) * (60 * hours + minutes);
    return true;
}

bool rmap_time_parse(const char *text, double *seconds_ret)
{
    static const int days_of[] = {31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    const int year = take(&text, 4);
    if (year < 0 || !skip(&text, '-'))
        return false;
    const int month = take(&text, 2);
    if (month < 1 || month > 12 || !skip(&text, '-'))
        return false;
    const int day = take(&text, 2);
    const bool leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    if (day < 1 || day > days_of[month - 1] - (month == 2 && !leap) ||
        (!skip(&text, 'T') && !skip(&text, ' ')))
        return false;
    const int hour = take(&text, 2);
    if (hour < 0 || hour > 24 || !skip(&text, ':'))
        return false;
    const int minute = take(&text, 2);
    double second = 0.0;
    if (minute < 0 || minute > 59)
        return false;
    if (skip(&text, ':')) {
        const int whole = take(&text, 2);
        double unit = 0.1;
        if (whole < 0 || whole > 60)
            return false;
        second = whole;
        if (skip(&text, '.'))
            for (; *text >= '0' && *text <= '9'; text++, unit *= 0.1)
                second += unit * (*text - '0');
    }
    int ahead = 0;
    if (!take_zone(&text, &ahead) || *text)
        return false;
    *seconds_ret = 86400.0 * ((double)days_since_2000(year, month, day) - 0.5) +
                   60.0 * (60.0 * hour + minute - ahead) + second;
    return true;
}

/* ---- place ---- */

static const double degree = RMAP_PI / 180.0;

static double within(double x, double period)
{
    return x - period * floor(x / period);
}

/* Mean anomaly. */
static double anomaly(double days)
{
    return within(357.528 + 0.9856003 * days, 360.0) * degree;
}

/* How much higher it is seen, in degrees. */
static double refraction(double altitude)
{
    const double low = altitude < -1.0 ? -1.0 : altitude;
    return altitude < -5.0 ? 0.0 : 1.02 / 60.0 / tan((low + 10.3 / (low + 5.11)) * degree);
}

struct rmap_sun_place rmap_sun_place(double latitude, double longitude, double seconds)
{
    const double days = seconds / 86400.0, g = anomaly(days),
                 along = within(280.460 + 0.9856474 * days + 1.915 * sin(g) + 0.020 * sin(2.0 * g),
                                360.0) *
                         degree,
                 obliquity = (23.439 - 0.0000004 * days) * degree,
                 ascension = atan2(cos(obliquity) * sin(along), cos(along)),
                 declination = asin(sin(obliquity) * sin(along)),
                 hours = within(days + 0.5, 1.0) * 24.0,
                 sidereal = 6.697375 + 0.0657098242 * days + hours + longitude / 15.0,
                 turned = within(sidereal, 24.0) * 15.0 * degree - ascension,
                 sine = sin(latitude * degree), cosine = cos(latitude * degree),
                 up = sin(declination) * sine + cos(declination) * cosine * cos(turned),
                 north = sin(declination) * cosine - cos(declination) * sine * cos(turned),
                 east = -cos(declination) * sin(turned);
    struct rmap_sun_place place = {.azimuth = within(atan2(east, north) / degree, 360.0),
                                   .altitude = atan2(up, hypot(north, east)) / degree};
    place.altitude -= 8.794 / 3600.0 * cos(place.altitude * degree); /* seen from the ground */
    place.altitude += refraction(place.altitude);
    return place;
}

double rmap_sun_nearness(double seconds)
{
    const double g = anomaly(seconds / 86400.0),
                 distance = 1.00014 - 0.01671 * cos(g) - 0.00014 * cos(2.0 * g);
    return 1.0 / (distance * distance);
}

/* ---- shape ---- */

double rmap_sunshape_end(enum rmap_sunshape shape, double size)
{
    switch (shape) {
    case RMAP_SUNSHAPE_PILLBOX:
        return size;
    case RMAP_SUNSHAPE_GAUSS:
        return 6.0 * size;
    case RMAP_SUNSHAPE_BUIE:
        break;
    }
    return 43.6e-3;
}

static double portable_cos(double x)
{
    double cosine, sine;
    rmap_azimuth(x / (2.0 * RMAP_PI), &cosine, &sine);
    return cosine;
}

double rmap_sunshape_at(enum rmap_sunshape shape, double size, double angle)
{
    const double mrad = 1e3 * angle;
    if (angle > rmap_sunshape_end(shape, size))
        return 0.0;
    switch (shape) {
    case RMAP_SUNSHAPE_PILLBOX:
        return 1.0;
    case RMAP_SUNSHAPE_GAUSS:
        return rmap_portable_exp(-0.5 * (angle / size) * (angle / size));
    case RMAP_SUNSHAPE_BUIE:
        break;
    }
    if (angle <= RMAP_SUN_RIM)
        return portable_cos(0.326 * mrad) / portable_cos(0.308 * mrad);
    if (!(size > 0.0))
        return 0.0;
    const double kappa = 0.9 * rmap_portable_log(13.5 * size) * rmap_portable_power(size, -0.3),
                 gamma =
                     2.2 * rmap_portable_log(0.52 * size) * rmap_portable_power(size, 0.43) - 0.1;
    return rmap_portable_exp(kappa) * rmap_portable_power(mrad, gamma);
}
