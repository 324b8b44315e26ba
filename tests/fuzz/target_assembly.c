/* SPDX-License-Identifier: MIT
 *
 * An assembly from a stranger, as JSON or as glTF, its materials, and names and faults of OBJ and
 * STL: it is refused with a sentence, or becomes texts that are YAML, and a revision of another;
 * memory that cannot be had is told.
 */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/assembly/assembly_match.h"
#include "io/assembly/assembly_scene.h"
#include "io/mesh/gltf_tree.h"
#include "io/mesh/obj_names.h"
#include "io/mesh/text_fault.h"
#include "io/scene/yaml_tree.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 6000;

enum { LONGEST = 16384 };

static const char whole[] =
    "{\"format\":\"raymap-assembly\",\"version\":1,\"source\":\"a\",\"shapes\":[{\"id\":\"s\","
    "\"file\":\"a.ply\",\"name\":\"a\",\"hash\":\"00000000000000000000000000000000\",\"bounds\":[["
    "0,"
    "0,0],[1,1,1]],\"form\":\"00000000000000000000000000000001\",\"closed\":true,\"digest\":"
    "\"0x1\","
    "\"faces\":[{\"name\":\"\",\"middle\":[0.5,0.5,0]}]}],\"parts\":[{\"id\":\"x\",\"name\":\"X\","
    "\"shape\":\"s\"}]}";

static enum rmap_status write_text(const struct rmap_assembly *assembly,
                                   enum rmap_status (*put)(const void *context, FILE *out,
                                                           struct rmap_error *err),
                                   struct rmap_error *err)
{
    char *text = NULL;
    size_t nbytes = 0;
    struct rmap_diagnostics told;
    struct rmap_yaml_node *tree = NULL;
    FILE *out = open_memstream(&text, &nbytes);
    rmap_fuzz_demand(out != NULL, "memory");
    enum rmap_status st = put(assembly, out, err);
    rmap_fuzz_demand(fclose(out) == 0, "a stream in memory");
    rmap_diagnostics_init(&told, "parts.yaml");
    if (st == RMAP_OK) {
        st = rmap_yaml_parse(text, nbytes, &tree, &told, err);
        rmap_fuzz_demand(st == RMAP_SYSTEM || (st == RMAP_OK && told.n_error == 0), "YAML");
    }
    rmap_yaml_destroy(tree);
    rmap_diagnostics_fini(&told);
    free(text);
    return st;
}

static enum rmap_status use(struct rmap_assembly *after, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly before = {0};
    struct rmap_assembly_match match = {0};
    RMAP_TRY(rmap_assembly_read_json(whole, strlen(whole), &before, err));
    RMAP_TRY(rmap_assembly_settle_labels(&before, err));
    rmap_assembly_keep_frames(&before, after);
    RMAP_TRY(rmap_assembly_match(&before, after, &match, err));
    RMAP_TRY(rmap_assembly_adopt(&before, after, &match, err));
    RMAP_TRY(rmap_assembly_settle_labels(after, err));
    RMAP_TRY(rmap_assembly_settle_files(after, err));
    RMAP_TRY(write_text(after, rmap_assembly_put_parts, err));
    RMAP_TRY(write_text(after, rmap_assembly_put_attributes, err));
    st = write_text(after, rmap_assembly_put_scene, err);
out:
    rmap_assembly_match_fini(&match);
    rmap_assembly_fini(&before);
    return st;
}

/* A revision in which nothing changed. */
static enum rmap_status use_twice(const char *text, size_t nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly before = {0}, after = {0};
    struct rmap_assembly_match match = {0};
    RMAP_TRY(rmap_assembly_read_json(text, nbytes, &before, err));
    RMAP_TRY(rmap_assembly_settle_labels(&before, err));
    RMAP_TRY(rmap_assembly_read_json(text, nbytes, &after, err));
    rmap_assembly_keep_frames(&before, &after);
    RMAP_TRY(rmap_assembly_match(&before, &after, &match, err));
    for (size_t i = 0; i < after.n_part; i++)
        rmap_fuzz_demand(match.from[i] >= 0 && match.change[i] == 0 &&
                             match.to[match.from[i]] == (int32_t)i,
                         "all is as it was");
    RMAP_TRY(rmap_assembly_adopt(&before, &after, &match, err));
    RMAP_TRY(rmap_assembly_settle_labels(&after, err));
    for (size_t i = 0; i < after.n_part; i++)
        rmap_fuzz_demand(after.part[i].number == before.part[match.from[i]].number &&
                             strcmp(after.part[i].label, before.part[match.from[i]].label) == 0,
                         "names and numbers are kept");
out:
    rmap_assembly_match_fini(&match);
    rmap_assembly_fini(&before);
    rmap_assembly_fini(&after);
    return st;
}

static void read_gltf(const uint8_t *data, size_t nbytes, struct rmap_error *err)
{
    struct rmap_gltf_tree tree = {0};
    const enum rmap_status st = rmap_gltf_read_tree("a.gltf", data, nbytes, 1000, &tree, err);
    rmap_fuzz_demand(st == RMAP_OK || err->text[0], "what is wrong is said");
    for (size_t i = 0; st == RMAP_OK && i < tree.n_node; i++)
        rmap_fuzz_demand(tree.node[i].parent < (int32_t)i, "parents come first");
    rmap_gltf_tree_fini(&tree);
}

static void read_obj(const uint8_t *data, size_t nbytes, struct rmap_error *err)
{
    struct rmap_obj_names names = {0};
    char why[200] = "";
    const enum rmap_status st = rmap_obj_names_read(data, nbytes, &names, err);
    rmap_fuzz_demand(st == RMAP_OK || err->text[0], "what is wrong is said");
    for (size_t i = 0; st == RMAP_OK && i < names.n; i++)
        rmap_fuzz_demand(names.name[i][0] != 0 && (unsigned char)names.name[i][0] > ' ', "a name");
    rmap_obj_names_fini(&names);
    rmap_fuzz_demand(!rmap_obj_fault(data, nbytes, why, sizeof why) || why[0], "a reason");
    rmap_fuzz_demand(!rmap_stl_fault(data, nbytes, why, sizeof why) || why[0], "a reason");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_assembly assembly = {0};
    struct rmap_error err = {0};
    const int64_t live = rmap_alloc_live();
    if (nbytes < 3 || nbytes > LONGEST)
        return 0;
    enum rmap_status st = RMAP_OK;
    char *text = rmap_alloc(nbytes, 1);
    rmap_fuzz_demand(text != NULL, "memory");
    memcpy(text, data + 2, nbytes - 2);
    if (data[1] >= 'a') /* letters: one of the first calls for memory fails */
        rmap_alloc_fail_at(1 + (data[1] - 'a') * 5);
    if (data[0] % 4 == 0) {
        st = rmap_assembly_read_json(text, nbytes - 2, &assembly, &err);
        if (st == RMAP_OK)
            st = use(&assembly, &err);
        if (st == RMAP_OK)
            st = use_twice(text, nbytes - 2, &err);
        rmap_fuzz_demand(st == RMAP_OK || err.text[0], "what is wrong is said");
    } else if (data[0] % 4 == 1) {
        read_gltf((const uint8_t *)text, nbytes - 2, &err);
    } else if (data[0] % 4 == 3) {
        read_obj((const uint8_t *)text, nbytes - 2, &err);
    } else {
        st = rmap_assembly_read_mtl(text, &assembly, &err);
        rmap_fuzz_demand(st == RMAP_OK || err.text[0], "what is wrong is said");
    }
    rmap_alloc_fail_at(0);
    rmap_free(text);
    rmap_assembly_fini(&assembly);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    static const char *const seed[] = {
        "0A{\"format\":\"raymap-assembly\",\"version\":1,\"source\":\"a.step\",\"schema\":"
        "\"AP214\","
        "\"writer\":\"W\",\"file_unit\":\"in\",\"chord\":0.1,\"angle\":10,\"shapes\":[{\"id\":"
        "\"s1\","
        "\"file\":\"lens.ply\",\"name\":\"Lens\",\"closed\":true,\"hash\":"
        "\"0123456789abcdef0123456789abcdef\",\"bounds\":[[0,0,0],[1,2,3]],\"faces\":[{\"name\":"
        "\"a\","
        "\"color\":[1,0,0]},{\"name\":\"\",\"color\":null}]}],\"parts\":[{\"id\":\"1\",\"name\":"
        "\"top:"
        " #\",\"parts\":[{\"id\":\"1/2\",\"name\":\"Lens "
        "'1'\",\"color\":[0.5,0.5,0.5],\"material\":"
        "\"N-BK7\",\"matrix\":[0,-1,0,5,1,0,0,0,0,0,1,0],\"shape\":\"s1\"},{\"id\":\"1/"
        "2\",\"name\":"
        "\"Lens "
        "'1'\",\"matrix\":[2,0,0,0,0,1,0,0,0,0,-1,0],\"shape\":\"s1\"},{\"id\":\"e\",\"name\":\"\","
        "\"parts\":[]}]}],\"materials\":[{\"name\":\"m\",\"color\":[1,1,1],\"transmission\":1,"
        "\"index\":"
        "1.5}],\"touching\":[[\"1/2\",\"1\",2.5]],\"findings\":[{\"text\":\"t\",\"part\":null}]}",
        "1A{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"name\":"
        "\"a\","
        "\"children\":[1]},{\"mesh\":0,\"rotation\":[0,0,0.7,0.7]}],\"meshes\":[{\"name\":\"m\","
        "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],\"materials\":[{"
        "\"name\":"
        "\"x\"}],\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"bufferView\":0}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
        "\"uri\":"
        "\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
        "3Amtllib a.mtl\no a b\nv 0 0 0\nv 1 0 0\r\nv 0 1 x\ng c d\nusemtl m\nf 1/2/3 -1 9\ng  \no "
        "a b\ng c d\nf 1 2 3\nvertex 1 2\n",
        "2Anewmtl a b\nKd 1 0.5 0\nd 0.2\nNi 1.5\nnewmtl c\nTr 1\nPm 1\nPr 0.3\n",
        "0c{\"format\":\"raymap-assembly\",\"version\":1,\"shapes\":[{\"id\":\"s1\",\"file\":\"l."
        "ply\","
        "\"hash\":\"0123456789abcdef0123456789abcdef\",\"bounds\":[[0,0,0],[1,2,3]],\"faces\":[{}]}"
        "],"
        "\"parts\":[{\"id\":\"1\",\"name\":\"n\",\"shape\":\"s1\"}]}",
    };
    return rmap_fuzz_seed_text(seed, sizeof seed / sizeof *seed, k, to, cap);
}
