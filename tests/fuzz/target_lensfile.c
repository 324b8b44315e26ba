/* SPDX-License-Identifier: MIT
 *
 * A lens file from a stranger, of any of the formats, a glass catalogue and an archive: it is
 * refused with a sentence, or becomes a scene whose text is YAML that the scene's reader can judge.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lensfile/lens_scene.h"
#include "io/lensfile/lens_zar.h"
#include "io/scene/yaml_tree.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 12000;

enum { LONGEST = 16384, GLASS = 3, ARCHIVE = 4, KINDS = 5 }; /* after the lens formats */

static void check_numbers(const struct rmap_lens_plan *plan)
{
    for (size_t i = 1; i < plan->lens->n_surface; i++) {
        const struct rmap_lens_place *place = &plan->place[i];
        rmap_fuzz_demand(place->semi >= 0, "a semi-diameter");
    }
    for (size_t i = 0; i < plan->media.n; i++)
        rmap_fuzz_demand(plan->media.medium[i].index > 0, "an index");
    rmap_fuzz_demand(plan->order.entrance_diameter > 0, "a pupil");
}

static void write(const struct rmap_lens_plan *plan)
{
    char *text = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&text, &nbytes);
    rmap_fuzz_demand(out != NULL, "memory");
    rmap_lens_scene_write(plan, "a.zmx", out);
    rmap_fuzz_demand(fclose(out) == 0, "a stream in memory");
    struct rmap_diagnostics told;
    struct rmap_yaml_node *tree = NULL;
    struct rmap_error err = {0};
    rmap_diagnostics_init(&told, "scene.yaml");
    const enum rmap_status st = rmap_yaml_parse(text, nbytes, &tree, &told, &err);
    rmap_fuzz_demand(st == RMAP_OK && told.n_error == 0, "YAML");
    rmap_yaml_destroy(tree);
    rmap_diagnostics_fini(&told);
    free(text);
}

static enum rmap_status unpack(const uint8_t *data, size_t nbytes, struct rmap_error *err)
{
    struct rmap_zar_file file;
    size_t at = 0;
    bool found = true;
    enum rmap_status st = RMAP_OK;
    for (int i = 0; i < 32 && st == RMAP_OK && found; i++) {
        st = rmap_zar_next(data, nbytes, &at, NULL, &file, &found, err);
        rmap_fuzz_demand(st != RMAP_OK || !found || file.bytes[file.nbytes] == 0, "a 0 behind it");
        rmap_fuzz_demand(at <= nbytes, "a place in it");
        rmap_free(file.bytes);
    }
    return st;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_prescription lens = {0};
    struct rmap_lens_plan plan = {0};
    struct rmap_diagnostics findings;
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    if (nbytes < 2 || nbytes > LONGEST)
        return 0;
    const char *text = (const char *)data + 1;
    rmap_diagnostics_init(&findings, "a.zmx");
    enum rmap_status st = RMAP_OK;
    const unsigned kind = (data[0] + KINDS * KINDS * 4U - '0') % KINDS;
    if (kind == ARCHIVE) {
        st = unpack(data + 1, nbytes - 1, &err);
    } else if (kind == GLASS) {
        st = rmap_prescription_read_agf(text, nbytes - 1, &lens, &err);
        const double nm[] = {400, 600};
        for (size_t i = 0; i < lens.n_glass; i++) {
            struct rmap_glass glass;
            (void)rmap_agf_to_glass(&lens.glass[i], nm, 2, &glass);
        }
    } else {
        st = rmap_prescription_read(text, nbytes - 1, (enum rmap_lens_format)kind, data[0] / 16 % 3,
                                    &findings, &lens, &err);
        if (st == RMAP_OK)
            st = rmap_lens_plan_make(&lens, &plan, &err);
        if (st == RMAP_OK) {
            check_numbers(&plan);
            write(&plan);
        }
    }
    rmap_fuzz_demand(st == RMAP_OK || (st == RMAP_INPUT && err.text[0]), "what is wrong is said");
    rmap_lens_plan_fini(&plan);
    rmap_prescription_fini(&lens);
    rmap_diagnostics_fini(&findings);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* An archive of both kinds of heads, a file packed as two codes of 9 bits, "ab", and one that is
 * not. */
static size_t seed_archive(uint8_t *to, size_t cap)
{
    enum { OLD = 0x14c, NEW = 0x288, NBYTES = 1 + OLD + 3 + NEW + 4 };
    static const uint8_t packed[] = {0x30, 0x98, 0x80};
    if (cap < NBYTES)
        return 0;
    memset(to, 0, NBYTES);
    to[0] = '4';
    uint8_t *head = to + 1;
    head[0] = 0xea;
    head[0x0c] = sizeof packed;
    memcpy(head + 0x20, "A.ZMX.LZW", 9);
    memcpy(head + OLD, packed, sizeof packed);
    head += OLD + sizeof packed;
    head[0] = 0xec;
    head[0x10] = 4;
    memcpy(head + 0x30, "B\0.\0A\0G\0F", 9);
    memcpy(head + NEW, "NM x", 4);
    return NBYTES;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "0UNIT MM X W X CM MR CPMM\nENPD 15\nGCAT SCHOTT OHARA\nFTYP 0 0 2 2 0\nYFLN 0 5\nWAVM 1 "
        "0.55 1\nWAVM 2 .65 2\nPWAV 1\nSURF 0\n  TYPE STANDARD\n  DISZ INFINITY\nSURF 1\n  STOP\n  "
        "TYPE EVENASPH\n  CURV 0.07\n  PARM 2 9e-5\n  CONI -2\n  DISZ 4\n  GLAS N-BK7 0 0 1.5 40\n "
        " "
        "DIAM 7 1 0 0 1 \"\"\nSURF 2\n  TYPE STANDARD\n  CURV 0\n  DISZ 20\nSURF 3\n  DISZ 0\n",
        "0FLOA\nFTYP 1 0 1 1\nSURF 0\n  DISZ 100\nSURF 1\n  TYPE COORDBRK\n  PARM 3 45\n  PARM 6 "
        "1\n"
        "  DISZ 0\nSURF 2\n  STOP\n  GLAS MIRROR 0 0\n  CURV -.01\n  OBSC 0 2\n  DIAM 9\n  DISZ "
        "-40\nSURF 3\n  GLAS ___BLANK 1 0 1.6 40\n  SQAP 3 4\n  TYPE XASPHERE\n  XDAT 1 2\n  XDAT "
        "2 "
        "10\n  XDAT 3 .1\n  XDAT 4 .2\n  DISZ -4\nSURF 4\n  DISZ -9\nSURF 5\n",
        "1RDM;LEN\nTITLE 'a; b'\nEPD 50\nDIM M\nWL 656.3 587.6\nREF 2\nYAN 0 14\nVUY 0 .4\nSO 0 "
        "1e12\nS 56 8.7 NSSK2_SCHOTT\nASP\nK -1; A 1e-6; B &\n 2e-9\nS -100 10\nSTO\nS -80 -5 REFL "
        "! "
        "x\nYDE 1; ADE 10; BEN\nS 20 -3 569.631\nS 0 -20\nSI 0 -.4\nGO\n",
        "DUNIT IN\nFTYP 0 0 1 1\nSURF 0\n  DISZ INFINITY\nSURF 1\n  TYPE SZERNSAG\n  CURV .01\n  "
        "PARM 2 "
        "1e-6\n  XDAT 1 5\n  XDAT 2 12\n  XDAT 6 .02\n  XDAT 7 .1\n  GLAS N-BK7 4 0 1.5 40 0 0 0 0 "
        ".01 .2\n  "
        "ELAP 5 3\n  OBDC 1 0\n  DISZ 3\nSURF 2\n  TYPE BICONICX\n  PARM 1 120\n  PARM 2 -2\n  "
        "SPID .2 3\n  "
        "CLOB 0 1\n  DISZ 4\n  TCOM 1 7\nSURF 3\n  STOP\n  SQAP 3 4\n  DISZ 5\nSURF 4\n  TYPE "
        "QED_TYPE\n  "
        "XDAT 1 0\n  XDAT 2 3\n  XDAT 3 12\n  XDAT 4 .1\n  XDAT 6 .2\n  GLAS N-SF6\n  DISZ 2\nSURF "
        "5\n  TYPE "
        "TOROIDAL\n  PARM 1 -60\n  PARM 3 1e-5\n  DISZ 2\nSURF 6\n  TYPE GRINSUR5\n  PARM 2 1.6\n  "
        "PARM 3 "
        "-1e-3\n  DISZ 2\nSURF 7\n  TYPE FRESNELS\n  DISZ 9\nSURF 8\nMNUM 2 1\nLTTL 0 2 "
        "\"a\"\nTHIC 3 2 6\nCRVT "
        "1 2 .02\nGLSS 1 2 \"MIRROR\"\nYFIE 1 2 3\nPRAM 1 2 4\n",
        "1RDM;LEN\nEPD 9\nWL 587.6\nPRV\nPWL 650 587.6\n'M' 1.5 1.6\nEND\nSO 0 1e20\nS 90 4 "
        "'M'\nSTO\nSPS XYP "
        "10\nSCO C5 .03; SCO X1Y2 .1\nREX 4; REY 3; ADX 1\nS 80 3\nAAS\nRDX 70; KX -1; AR 1e-6; AP "
        ".3\nS 60 -4 "
        "REFL\nXTO; RDX 40\nCIR HOL 2\nS 0 -5 1.6:40\nSPS ZRN\nSCO C9 .01\nS 0 -5\nSPS QCN 9\nSCO "
        "QC6 .1\nDIF "
        "DOE\nSI 0 0\nZOO 2\nTIT Z2 'far'\nZOO THI S2 3 4\nZOO YAN F1 0 1\n",
        "2LEN NEW \"B\" 9 3\nEBR 5\nWV .58 .48\nTH 1e20\nNXT\nRFL\nTLA 45\nDCX 1\nDT "
        "-1\nBEN\nAST\nTH "
        "-30\nNXT\nGLA MOD M 1.6 1.7\nCVX .02\nRD 30\nTH -3\nNXT\nRCO 2\nAS1 1e-5\nGSP .1\nTH "
        "-9\nNXT\nEND 4\n",
        "2LEN NEW \"A\" 100 3\nEBR 5\nANG 10\nUNI 1\nAIR\nTH 1e20\nNXT\nGLA BK7\nRD 50\nTH 3\nAP "
        "6\nAST\nNXT\nAIR\nRD -50\nTH 48\nAD 1e-5\nNXT\nAIR\nTH 0\nWV .55 .65\nEND 3\n",
        "3NM N-BK7 2 0 1.5168 64.17\nGC x\nCD 1.03961212 6.00069867E-3 2.31792344E-1 2.00179144E-2 "
        "1.01046945 103.560653\nLD .3 2.5\nNM B 5 0 1.5 60\nCD 1.5 .01 .001\nNM C 13 0 1.5 60\nCD "
        "2.2 "
        "0 0 .01\n",
    };
    if (k == sizeof seed / sizeof *seed)
        return seed_archive(to, cap);
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
