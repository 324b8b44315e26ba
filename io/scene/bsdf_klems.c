/* SPDX-License-Identifier: MIT
 *
 * XML of the program WINDOW: matrices on Klems's bases. A line is a patch that light goes out
 * through, a column one that it came in by; each goes by the tangential direction of travel.
 * WINDOW's front is outdoors: light that meets an object's front finds the file's Back.
 */
#include <libxml/parser.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "base/late_library.h"
#include "io/scene/scene_tables.h"

enum { RINGS_MAX = 100, PATCHES_MAX = 2000 };

/* The angle basis of the file. */
struct basis {
    size_t n_ring, n;
    double edge_deg[RINGS_MAX + 1];
    size_t n_phi[RINGS_MAX];
};

#define XML(X)                                                                                     \
    X(xmlNewParserCtxt)                                                                            \
    X(xmlCtxtReadMemory)                                                                           \
    X(xmlCtxtGetLastError)                                                                         \
    X(xmlDocGetRootElement)                                                                        \
    X(xmlGetLineNo)                                                                                \
    X(xmlFreeDoc)                                                                                  \
    X(xmlFreeParserCtxt)

struct xml {
    XML(RMAP_LATE_MEMBER)
};
static const char *const xml_name[] = {XML(RMAP_LATE_NAME)};

static enum rmap_status load_xml(struct xml *by, struct rmap_error *err)
{
    return rmap_late_library(RMAP_LIBXML, "XML is read by libxml2", xml_name, RMAP_COUNT(xml_name),
                             by, err);
}

static long line_of(const xmlNode *node)
{
    struct xml by;
    return load_xml(&by, NULL) == RMAP_OK ? by.xmlGetLineNo(node) : 0;
}

static bool is_called(const xmlNode *node, const char *name)
{
    return node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0;
}

static const xmlNode *child(const xmlNode *node, const char *name)
{
    const xmlNode *at = node ? node->children : NULL;
    while (at && !is_called(at, name))
        at = at->next;
    return at;
}

/* The next of this name in the order of the document, behind `at`, within `root`. */
static const xmlNode *next_called(const xmlNode *root, const xmlNode *at, const char *name)
{
    for (;;) {
        if (at->children && at->type == XML_ELEMENT_NODE) {
            at = at->children;
        } else {
            while (at != root && !at->next)
                at = at->parent;
            if (at == root)
                return NULL;
            at = at->next;
        }
        if (is_called(at, name))
            return at;
    }
}

/* Its text; NULL: not one text alone. */
static const char *text_of(const xmlNode *node)
{
    const xmlNode *text = node ? node->children : NULL;
    return text && text->type == XML_TEXT_NODE && !text->next ? (const char *)text->content : NULL;
}

static bool says(const xmlNode *node, const char *word)
{
    const char *text = text_of(node);
    while (text && strchr(" \t\r\n", *text) && *text)
        text++;
    const size_t n = strlen(word);
    return text && strncmp(text, word, n) == 0 && text[n + strspn(text + n, " \t\r\n")] == 0;
}

static bool number_of(const xmlNode *node, double *value)
{
    const char *text = text_of(node);
    char *end = NULL;
    if (!text)
        return false;
    *value = strtod(text, &end);
    return end != text && end[strspn(end, " \t\r\n")] == 0 && isfinite(*value);
}

static enum rmap_status read_basis(const xmlNode *root, struct basis *basis, struct rmap_error *err)
{
    const xmlNode *block = root;
    while ((block = next_called(root, block, "AngleBasisBlock")) != NULL) {
        const xmlNode *bounds = child(block, "ThetaBounds");
        double low, high, n;
        if (basis->n_ring == RINGS_MAX || !number_of(child(bounds, "LowerTheta"), &low) ||
            !number_of(child(bounds, "UpperTheta"), &high) ||
            !number_of(child(block, "nPhis"), &n) ||
            !(low == basis->edge_deg[basis->n_ring] && high > low && high <= 90.0) ||
            !(n >= 1.0 && n <= 720.0 && n == floor(n)) || basis->n + (size_t)n > PATCHES_MAX)
            return rmap_error_set(
                err, RMAP_INPUT,
                "line %ld: an AngleBasisBlock has nPhis and ThetaBounds that go on "
                "where the last ended, from 0 to 90",
                line_of(block));
        basis->n_phi[basis->n_ring] = (size_t)n;
        basis->edge_deg[++basis->n_ring] = high;
        basis->n += (size_t)n;
    }
    if (basis->n_ring == 0 || basis->edge_deg[basis->n_ring] != 90.0)
        return rmap_error_set(err, RMAP_INPUT,
                              "its angle basis does not reach from 0 to 90 degrees");
    return RMAP_OK;
}

/* n x n numbers: value[column][line] or, where rows are incident, the other way. */
static enum rmap_status read_matrix(const xmlNode *node, size_t n, bool by_columns, double *value,
                                    struct rmap_error *err)
{
    const char *at = text_of(node);
    for (size_t i = 0; at && i < n * n; i++) {
        char *end = NULL;
        at += strspn(at, " \t\r\n,");
        const double f = strtod(at, &end);
        if (end == at)
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %ld: ScatteringData has %zu numbers, not %zu x %zu",
                                  line_of(node), i, n, n);
        if (!(f >= 0.0) || !isfinite(f))
            return rmap_error_set(err, RMAP_INPUT,
                                  "line %ld: number %zu of ScatteringData is %g: a BSDF is not "
                                  "negative",
                                  line_of(node), i + 1, f);
        value[by_columns ? i % n * n + i / n : i] = f;
        at = end;
    }
    if (!at || at[strspn(at, " \t\r\n,")] != 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "line %ld: ScatteringData is no list of %zu x %zu numbers",
                              node ? line_of(node) : 0L, n, n);
    return RMAP_OK;
}

/* WavelengthData of the band with the direction, or NULL. */
static const xmlNode *find_block(const xmlNode *root, bool solar, bool passes, const char *side)
{
    char direction[40];
    const xmlNode *data = root;
    (void)snprintf(direction, sizeof direction, "%s %s", passes ? "Transmission" : "Reflection",
                   side);
    while ((data = next_called(root, data, "WavelengthData")) != NULL) {
        const xmlNode *block = child(data, "WavelengthDataBlock");
        if (says(child(data, "Wavelength"), solar ? "Solar" : "Visible") &&
            says(child(block, "WavelengthDataDirection"), direction))
            return block;
    }
    return NULL;
}

static enum rmap_status read_tree(const xmlNode *root, const struct rmap_bsdf_wanted *wanted,
                                  struct rmap_scatter_table **table_ret, struct rmap_error *err)
{
    static const char *const side[2] = {"Front", "Back"}; /* of light from the back, the front */
    enum rmap_status st = RMAP_OK;
    struct basis basis = {.n_ring = 0};
    struct rmap_scatter_table *table = NULL;
    const xmlNode *structure = next_called(root, root, "IncidentDataStructure"), *block[2];
    const bool by_columns = says(structure, "Columns");
    if (!structure || (!by_columns && !says(structure, "Rows"))) {
        const char *text = text_of(structure);
        return rmap_error_set(err, RMAP_INPUT,
                              "it holds no Klems matrix: its IncidentDataStructure is '%.40s'; "
                              "export it on a Klems basis (genBSDF without -t4)",
                              text ? text : "missing");
    }
    RMAP_TRY(read_basis(root, &basis, err));
    for (int s = 0; s < 2; s++)
        block[s] = find_block(root, wanted->solar, wanted->passes, side[s]);
    if (!block[0] && !block[1]) {
        st = rmap_error_set(err, RMAP_INPUT, "it has no %s data of the %s band",
                            wanted->passes ? "Transmission" : "Reflection",
                            wanted->solar ? "Solar" : "Visible");
        goto out;
    }
    RMAP_TRY(rmap_scatter_table_create(
        &(struct rmap_scatter_table_shape){.n_ring = basis.n_ring,
                                           .ring_deg = basis.edge_deg,
                                           .n_phi = basis.n_phi,
                                           .n_turn = 1,
                                           .n_band = 1,
                                           .side = {block[0] != NULL, block[1] != NULL}},
        &table, err));
    for (int s = 0; s < 2; s++)
        if (block[s])
            RMAP_TRY(read_matrix(child(block[s], "ScatteringData"), basis.n, by_columns,
                                 table->block[s].value, err));
    *table_ret = table;
    table = NULL;
out:
    rmap_scatter_table_destroy(table);
    return st;
}

enum rmap_status rmap_bsdf_klems_read(const char *text, size_t nbytes,
                                      const struct rmap_bsdf_wanted *wanted,
                                      struct rmap_scatter_table **table_ret, struct rmap_error *err)
{
    struct xml by;
    enum rmap_status st = load_xml(&by, err);
    if (st != RMAP_OK)
        return st;
    xmlParserCtxt *context = by.xmlNewParserCtxt();
    if (!context)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for XML");
    xmlDoc *document =
        by.xmlCtxtReadMemory(context, text, (int)nbytes, NULL, NULL,
                             XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING |
                                 XML_PARSE_NOCDATA | XML_PARSE_COMPACT | XML_PARSE_BIG_LINES);
    const xmlNode *root = document ? by.xmlDocGetRootElement(document) : NULL;
    if (!root) {
        const xmlError *why = by.xmlCtxtGetLastError(context);
        if (why && why->code == XML_ERR_NO_MEMORY)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for XML"));
        st = rmap_error_set(err, RMAP_INPUT, "line %d: it is no XML: %.120s", why ? why->line : 0,
                            why && why->message ? why->message : "it cannot be parsed");
        err->text[strcspn(err->text, "\n")] = 0;
    } else {
        st = read_tree(root, wanted, table_ret, err);
    }
out:
    by.xmlFreeDoc(document);
    by.xmlFreeParserCtxt(context);
    return st;
}
