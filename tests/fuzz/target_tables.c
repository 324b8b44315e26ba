/* SPDX-License-Identifier: MIT
 *
 * A table from a stranger: a measured BSDF, CSV or XML of Klems matrices, reflected or passing; a
 * measured coat or phase function. It is refused with a sentence, or becomes shares, and directions
 * that can be drawn.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/coat_csv.h"
#include "io/scene/phase_csv.h"
#include "io/scene/scene_tables.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 300000;

enum { LONGEST = 16384, DRAWS = 8 };

static void use(struct rmap_scatter_table *table, bool passes)
{
    struct rmap_scatter scatter = {.model = RMAP_SCATTER_TABLE, .amount = {1.0}, .table = table};
    double theta;
    const double most = rmap_scatter_table_finish(table, passes, &theta);
    rmap_fuzz_demand(most >= 0.0 && theta >= 0.0 && theta <= 90.0, "a total and its angle");
    for (uint64_t i = 0; i < DRAWS; i++) {
        const double z = ((double)i + 0.5) / DRAWS, s = sqrt(1.0 - z * z);
        const struct rmap_scattering at = {.scatter = &scatter,
                                           .passes = passes,
                                           .front = i % 2 == 0,
                                           .n1 = 1.0,
                                           .n2 = 1.0,
                                           .in = {s * cos((double)i), s * sin((double)i), -z}};
        const struct rmap_draw draw = {.seed = 1, .ray = i, .step = 1};
        const struct rmap_vec3 out = rmap_lobe_draw(&at, &draw);
        const double total = rmap_lobe_total(&at), length = rmap_length(out);
        rmap_fuzz_demand(total >= 0.0 && total <= most * (1.0 + 1e-12), "no more than the most");
        rmap_fuzz_demand(fabs(length - 1.0) < 1e-9, "a direction");
        if (total > 0.0)
            rmap_fuzz_demand(rmap_lobe_shape(&at, out) >= 0.0, "a density");
    }
}

static void read_coat(const char *text, size_t nbytes, const struct rmap_channels *channels)
{
    struct rmap_thin_film film = {.n_angle = 0};
    struct rmap_error err = {0};
    const enum rmap_status st = rmap_coat_csv_read(text, nbytes, channels, &film, &err);
    rmap_fuzz_demand(st == RMAP_OK || (st == RMAP_INPUT && err.text[0]), "what is wrong is said");
    for (size_t i = 0; i < 4 * film.n_angle; i++)
        rmap_fuzz_demand(film.share[i] >= 0.0 && film.share[i] <= 1.0 + 1e-5, "a share");
    rmap_free(film.angle);
    rmap_free(film.share);
}

static void read_phase(const char *text, size_t nbytes, const struct rmap_channels *channels)
{
    struct rmap_phase phase = {.n_profile = 0};
    struct rmap_error err = {0};
    const enum rmap_status st = rmap_phase_csv_read(text, nbytes, channels, &phase, &err);
    rmap_fuzz_demand(st == RMAP_OK || (st == RMAP_INPUT && err.text[0]), "what is wrong is said");
    for (size_t i = 0; st == RMAP_OK && i < phase.n_profile * DRAWS; i++) {
        const struct rmap_profile *profile = &phase.profile[i / DRAWS];
        const double turned = rmap_profile_draw(profile, ((double)(i % DRAWS) + 0.5) / DRAWS);
        rmap_fuzz_demand(turned >= 0.0 && turned <= 2.0, "an angle");
        rmap_fuzz_demand(rmap_profile_intensity(profile, turned) >= 0.0, "a density");
    }
    rmap_phase_fini(&phase);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    static const struct rmap_channels channels = {.n = 2, .wavelength_nm = {500.0, 600.0}};
    struct rmap_scatter_table *table = NULL;
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    if (nbytes < 2 || nbytes > LONGEST || memchr(data, 0, nbytes))
        return 0;
    const bool passes = data[0] & 1;
    const struct rmap_bsdf_wanted wanted = {&channels, passes, data[0] & 2};
    char *text = rmap_alloc(nbytes, 1); /* its last byte stays 0 */
    rmap_fuzz_demand(text != NULL, "memory");
    memcpy(text, data + 1, nbytes - 1);
    if (data[0] & 4) {
        (data[0] & 8 ? read_phase : read_coat)(text, nbytes - 1, &channels);
        rmap_free(text);
        rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
        return 0;
    }
    const enum rmap_status st =
        (text[0] == '<' ? rmap_bsdf_klems_read
         : data[0] & 8  ? rmap_bsdf_zemax_read
                        : rmap_bsdf_csv_read)(text, nbytes - 1, &wanted, &table, &err);
    if (st == RMAP_OK)
        use(table, passes);
    else
        rmap_fuzz_demand(st == RMAP_INPUT && err.text[0] && !table, "what is wrong is said");
    rmap_scatter_table_destroy(table);
    rmap_free(text);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "0# wavelength, theta_i, phi_i, theta_s, phi_s, value\n"
        "0,0,0,0,0,0.1\n0,0,0,0,180,0.1\n0,0,0,60,0,0.05\n0,0,0,60,180,0.2\n"
        "0,40,0,0,0,0.1\n0,40,0,0,180,0.1\n0,40,0,60,0,0.05\n0,40,0,60,180,0.2\n",
        "1wavelength theta_i phi_i theta_s phi_s value\n"
        "500 10 0 0 0 0.1\n500 10 0 45 0 0.2\n700 10 0 0 0 0.1\n700 10 0 45 0 0.3\n",
        "0 0 10 0 0 0 .1\n0 10 0 0 180 .2\n0 10 180 0 0 .1\n0 10 180 0 180 .2\n",
        "4wavelength angle Rs Rp Ts Tp\n500 0 .1 .1 .8 .8\n500 60 .3 .2 .6 .7\n600 0 .2 .2 .8 .8\n"
        "600 60 .3 .2 .6 .7\n",
        "<wavelength angle value\n500 0 1\n500 90 .1\n500 180 .2\n600 0 2\n600 90 0\n600 180 1\n",
        "8Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType "
        "BRDF\n"
        "SampleRotation 1\n0\nAngleOfIncidence 2\n0 50\nScatterAzimuth 3\n0 90 180\nScatterRadial "
        "3\n0 10 60\nMonochrome\nDataBegin\nTIS .1\n.5 .2 .1\n.5 .2 .1\n.5 .2 .1\nTIS .1\n.5 .2 "
        ".1\n.5 .2 .1\n.5 .3 .1\nDataEnd\n",
        "9Symmetry Asymmetrical4D\nScatterType BTDF\nSampleRotation 4\n0 120 240 360\n"
        "AngleOfIncidence 1\n30\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 20\nMonochrome\n"
        "DataBegin\nTIS 0\n.5 .2\n.5 .1\nTIS 0\n.5 .2\n.5 .3\nTIS 0\n.5 .2\n.5 .4\nTIS 0\n.5 "
        ".2\n.5 .1\nDataEnd\n",
        "0<W><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis>"
        "<AngleBasisBlock><nPhis>1</nPhis><ThetaBounds><LowerTheta>0</LowerTheta>"
        "<UpperTheta>40</UpperTheta></ThetaBounds></AngleBasisBlock><AngleBasisBlock>"
        "<nPhis>2</nPhis><ThetaBounds><LowerTheta>40</LowerTheta><UpperTheta>90</UpperTheta>"
        "</ThetaBounds></AngleBasisBlock></AngleBasis></DataDefinition><WavelengthData>"
        "<Wavelength>Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>"
        "Reflection Back</WavelengthDataDirection><ScatteringData>.1, .2, .1, .1 .05 .1, .2, .1 "
        ".1</ScatteringData></WavelengthDataBlock></WavelengthData></W>",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
