/* SPDX-License-Identifier: MIT
 *
 * Colour rendering index, CIE 13.3-1995. Sums over the scene's channels: light and reference are
 * taken in the same bands, so that the reference itself has 100.
 */
#include "optics/colour_rendering.h"

#include <math.h>
#include <string.h>

#include "optics/chromaticity.h"
#include "optics/illuminant.h"

/* clang-format off */
/* Radiance factors of the test samples, in thousandths, every 5 nm from 380 to 780 nm (CIE 13.3-1995). */
enum { SAMPLE_N = 81, SAMPLE_FROM_NM = 380, SAMPLE_STEP_NM = 5 };
static const short sample[RMAP_CRI_SAMPLES][SAMPLE_N] = {
    {219, 239, 252, 256, 256, 254, 252, 248, 244, 240, 237, 232, 230, 226, 225, 222, 220, 218, 216,
     214, 214, 214, 216, 218, 223, 225, 226, 226, 225, 225, 227, 230, 236, 245, 253, 262, 272, 283,
     298, 318, 341, 367, 390, 409, 424, 435, 442, 448, 450, 451, 451, 451, 451, 451, 450, 450, 451,
     451, 453, 454, 455, 457, 458, 460, 462, 463, 464, 465, 466, 466, 466, 466, 467, 467, 467, 467,
     467, 467, 467, 467, 467},
    {70, 79, 89, 101, 111, 116, 118, 120, 121, 122, 122, 122, 123, 124, 127, 128, 131, 134, 138,
     143, 150, 159, 174, 190, 207, 225, 242, 253, 260, 264, 267, 269, 272, 276, 282, 289, 299, 309,
     322, 329, 335, 339, 341, 341, 342, 342, 342, 341, 341, 339, 339, 338, 338, 337, 336, 335, 334,
     332, 332, 331, 331, 330, 329, 328, 328, 327, 326, 325, 324, 324, 324, 323, 322, 321, 320, 318,
     316, 315, 315, 314, 314},
    {65, 68, 70, 72, 73, 73, 74, 74, 74, 73, 73, 73, 73, 73, 74, 75, 77, 80, 85, 94, 109, 126, 148,
     172, 198, 221, 241, 260, 278, 302, 339, 370, 392, 399, 400, 393, 380, 365, 349, 332, 315, 299,
     285, 272, 264, 257, 252, 247, 241, 235, 229, 224, 220, 217, 216, 216, 219, 224, 230, 238, 251,
     269, 288, 312, 340, 366, 390, 412, 431, 447, 460, 472, 481, 488, 493, 497, 500, 502, 505, 510,
     516},
    {74, 83, 93, 105, 116, 121, 124, 126, 128, 131, 135, 139, 144, 151, 161, 172, 186, 205, 229,
     254, 281, 308, 332, 352, 370, 383, 390, 394, 395, 392, 385, 377, 367, 354, 341, 327, 312, 296,
     280, 263, 247, 229, 214, 198, 185, 175, 169, 164, 160, 156, 154, 152, 151, 149, 148, 148, 148,
     149, 151, 154, 158, 162, 165, 168, 170, 171, 170, 168, 166, 164, 164, 165, 168, 172, 177, 181,
     185, 189, 192, 194, 197},
    {295, 306, 310, 312, 313, 315, 319, 322, 326, 330, 334, 339, 346, 352, 360, 369, 381, 394, 403,
     410, 415, 418, 419, 417, 413, 409, 403, 396, 389, 381, 372, 363, 353, 342, 331, 320, 308, 296,
     284, 271, 260, 247, 232, 220, 210, 200, 194, 189, 185, 183, 180, 177, 176, 175, 175, 175, 175,
     177, 180, 183, 186, 189, 192, 195, 199, 200, 199, 198, 196, 195, 195, 196, 197, 200, 203, 205,
     208, 212, 215, 217, 219},
    {151, 203, 265, 339, 410, 464, 492, 508, 517, 524, 531, 538, 544, 551, 556, 556, 554, 549, 541,
     531, 519, 504, 488, 469, 450, 431, 414, 395, 377, 358, 341, 325, 309, 293, 279, 265, 253, 241,
     234, 227, 225, 222, 221, 220, 220, 220, 220, 220, 223, 227, 233, 239, 244, 251, 258, 263, 268,
     273, 278, 281, 283, 286, 291, 296, 302, 313, 325, 338, 351, 364, 376, 389, 401, 413, 425, 436,
     447, 458, 469, 477, 485},
    {378, 459, 524, 546, 551, 555, 559, 560, 561, 558, 556, 551, 544, 535, 522, 506, 488, 469, 448,
     429, 408, 385, 363, 341, 324, 311, 301, 291, 283, 273, 265, 260, 257, 257, 259, 260, 260, 258,
     256, 254, 254, 259, 270, 284, 302, 324, 344, 362, 377, 389, 400, 410, 420, 429, 438, 445, 452,
     457, 462, 466, 468, 470, 473, 477, 483, 489, 496, 503, 511, 518, 525, 532, 539, 546, 553, 559,
     565, 570, 575, 578, 581},
    {104, 129, 170, 240, 319, 416, 462, 482, 490, 488, 482, 473, 462, 450, 439, 426, 413, 397, 382,
     366, 352, 337, 325, 310, 299, 289, 283, 276, 270, 262, 256, 251, 250, 251, 254, 258, 264, 269,
     272, 274, 278, 284, 295, 316, 348, 384, 434, 482, 528, 568, 604, 629, 648, 663, 676, 685, 693,
     700, 705, 709, 712, 715, 717, 719, 721, 720, 719, 722, 725, 727, 729, 730, 730, 730, 730, 730,
     730, 730, 730, 730, 730},
    {66, 62, 58, 55, 52, 52, 51, 50, 50, 49, 48, 47, 46, 44, 42, 41, 38, 35, 33, 31, 30, 29, 28, 28,
     28, 29, 30, 30, 31, 31, 32, 32, 33, 34, 35, 37, 41, 44, 48, 52, 60, 76, 102, 136, 190, 256,
     336, 418, 505, 581, 641, 682, 717, 740, 758, 770, 781, 790, 797, 803, 809, 814, 819, 824, 828,
     830, 831, 833, 835, 836, 836, 837, 838, 839, 839, 839, 839, 839, 839, 839, 839},
    {50, 54, 59, 63, 66, 67, 68, 69, 69, 70, 72, 73, 76, 78, 83, 88, 95, 103, 113, 125, 142, 162,
     189, 219, 262, 305, 365, 416, 465, 509, 546, 581, 610, 634, 653, 666, 678, 687, 693, 698, 701,
     704, 705, 705, 706, 707, 707, 707, 708, 708, 710, 711, 712, 714, 716, 718, 720, 722, 725, 729,
     731, 735, 739, 742, 746, 748, 749, 751, 753, 754, 755, 755, 755, 755, 756, 757, 758, 759, 759,
     759, 759},
    {111, 121, 127, 129, 127, 121, 116, 112, 108, 105, 104, 104, 105, 106, 110, 115, 123, 134, 148,
     167, 192, 219, 252, 291, 325, 347, 356, 353, 346, 333, 314, 294, 271, 248, 227, 206, 188, 170,
     153, 138, 125, 114, 106, 100, 96, 92, 90, 87, 85, 82, 80, 79, 78, 78, 78, 78, 81, 83, 88, 93,
     102, 112, 125, 141, 161, 182, 203, 223, 242, 257, 270, 282, 292, 302, 310, 314, 317, 323, 330,
     334, 338},
    {120, 103, 90, 82, 76, 68, 64, 65, 75, 93, 123, 160, 207, 256, 300, 331, 346, 347, 341, 328,
     307, 282, 257, 230, 204, 178, 154, 129, 109, 90, 75, 62, 51, 41, 35, 29, 25, 22, 19, 17, 17,
     17, 16, 16, 16, 16, 16, 16, 16, 16, 18, 18, 18, 18, 19, 20, 23, 24, 26, 30, 35, 43, 56, 74, 97,
     128, 166, 210, 257, 305, 354, 401, 446, 485, 520, 551, 577, 599, 618, 633, 645},
    {104, 127, 161, 211, 264, 313, 341, 352, 359, 361, 364, 365, 367, 369, 372, 374, 376, 379, 384,
     389, 397, 405, 416, 429, 443, 454, 461, 466, 469, 471, 474, 476, 483, 490, 506, 526, 553, 582,
     618, 651, 680, 701, 717, 729, 736, 742, 745, 747, 748, 748, 748, 748, 748, 748, 748, 748, 747,
     747, 747, 747, 747, 747, 747, 746, 746, 746, 745, 744, 743, 744, 745, 748, 750, 750, 749, 748,
     748, 747, 747, 747, 747},
    {36, 36, 37, 38, 39, 39, 40, 41, 42, 42, 43, 44, 44, 45, 45, 46, 47, 48, 50, 52, 55, 57, 62, 67,
     75, 83, 92, 100, 108, 121, 133, 142, 150, 154, 155, 152, 147, 140, 133, 125, 118, 112, 106,
     101, 98, 95, 93, 90, 89, 87, 86, 85, 84, 84, 84, 84, 85, 87, 92, 96, 102, 110, 123, 137, 152,
     169, 188, 207, 226, 243, 260, 277, 294, 310, 325, 339, 353, 366, 379, 390, 399}};
/* clang-format on */

/* Bands that are too wide, or leave light out, say little of how it renders colours. */
static const double WIDEST_NM = 20.0, FROM_NM = 400.0, TO_NM = 700.0;

const char *rmap_cri_refused(const struct rmap_channels *channels)
{
    const double *nm = channels->wavelength_nm;
    if (channels->mode == RMAP_COLOUR_RGB)
        return "red, green and blue are no spectrum: take mode: spectral";
    int widest = 0;
    for (int i = 1; i < channels->n; i++)
        if (nm[i] > FROM_NM && nm[i - 1] < TO_NM && nm[i] - nm[i - 1] > WIDEST_NM * (1.0 + 1e-9))
            widest = i;
    return widest || nm[0] > FROM_NM || nm[channels->n - 1] < TO_NM
               ? "it takes wavelengths from 400 to 700 nm at least, 20 nm apart at most: "
                 "wavelengths: {from: 380, to: 780, step: 5}"
               : NULL;
}

static double reflectance(int k, double nm)
{
    const double at =
        fmin(fmax((nm - SAMPLE_FROM_NM) / SAMPLE_STEP_NM, 0.0), (double)(SAMPLE_N - 1));
    const int i = at < SAMPLE_N - 2 ? (int)at : SAMPLE_N - 2;
    return 0.001 * (sample[k][i] + (at - i) * (sample[k][i + 1] - sample[k][i]));
}

/* Of a light: its own u and v, and of each sample under it u, v and Y, the light's own being 100.
 */
struct seen {
    double uv[2], sample[RMAP_CRI_SAMPLES][3];
};

static void look(const struct rmap_channels *channels, const double *watt, struct seen *seen)
{
    double own[3] = {0.0, 0.0, 0.0}, xyz[RMAP_CRI_SAMPLES][3] = {{0.0}};
    for (int c = 0; c < channels->n; c++) {
        double bar[3];
        rmap_cie1931(channels->wavelength_nm[c], bar);
        for (int i = 0; i < 3; i++)
            own[i] += watt[c] * bar[i];
        for (int k = 0; k < RMAP_CRI_SAMPLES; k++) {
            const double its = reflectance(k, channels->wavelength_nm[c]);
            for (int i = 0; i < 3; i++)
                xyz[k][i] += watt[c] * bar[i] * its;
        }
    }
    rmap_uv1960(own, seen->uv);
    for (int k = 0; k < RMAP_CRI_SAMPLES; k++) {
        rmap_uv1960(xyz[k], seen->sample[k]);
        seen->sample[k][2] = 100.0 * xyz[k][1] / own[1];
    }
}

static void set_reference(const struct rmap_channels *channels, double kelvin, double *watt)
{
    double power[RMAP_ILLUMINANT_N];
    if (kelvin >= 5000.0) {
        rmap_illuminant_daylight(kelvin, power);
        rmap_illuminant_means(power, channels, watt);
    }
    for (int c = 0; c < channels->n; c++) {
        double band[2];
        rmap_channel_band(channels, c, band);
        if (kelvin < 5000.0)
            watt[c] = rmap_blackbody(kelvin, channels->wavelength_nm[c]);
        watt[c] *= band[1] - band[0];
    }
}

/* c and d of the adaptation. */
static void adapt(const double uv[2], double cd[2])
{
    cd[0] = (4.0 - uv[0] - 10.0 * uv[1]) / uv[1];
    cd[1] = (1.708 * uv[1] + 0.404 - 1.481 * uv[0]) / uv[1];
}

/* W*, U*, V* of 1964. */
static void place(const double uv[2], double y, const double white[2], double wuv[3])
{
    wuv[0] = 25.0 * cbrt(y) - 17.0;
    for (int i = 0; i < 2; i++)
        wuv[1 + i] = 13.0 * wuv[0] * (uv[i] - white[i]);
}

/* How far apart sample k stands in both lights, once the eye has adapted (von Kries). */
static double difference(const struct seen *light, const struct seen *reference, int k)
{
    double white[2], grey[2], own[2], there[3], here[3];
    adapt(reference->uv, white);
    adapt(light->uv, grey);
    adapt(light->sample[k], own);
    const double c = white[0] / grey[0] * own[0], d = white[1] / grey[1] * own[1];
    const double under = 16.518 + 1.481 * c - d;
    const double adapted[2] = {(10.872 + 0.404 * c - 4.0 * d) / under, 5.520 / under};
    place(reference->sample[k], reference->sample[k][2], reference->uv, there);
    place(adapted, light->sample[k][2], reference->uv, here);
    return sqrt(pow(there[0] - here[0], 2.0) + pow(there[1] - here[1], 2.0) +
                pow(there[2] - here[2], 2.0));
}

void rmap_cri_of(const struct rmap_channels *channels, const double *watt, double kelvin,
                 struct rmap_cri *cri)
{
    double white[RMAP_CHANNEL_MAX];
    struct seen light, reference;
    set_reference(channels, kelvin, white);
    look(channels, watt, &light);
    look(channels, white, &reference);
    cri->general = 0.0;
    for (int k = 0; k < RMAP_CRI_SAMPLES; k++) {
        cri->special[k] = 100.0 - 4.6 * difference(&light, &reference, k);
        if (k < RMAP_CRI_GENERAL)
            cri->general += cri->special[k] / RMAP_CRI_GENERAL;
    }
}
