/* SPDX-License-Identifier: MIT
 *
 * A mesh as a PLY file, with its faces.
 */
#include "io/assembly/ply_write.h"

#include <string.h>

#include "io/file/whole_file.h"
#include "io/lensfile/lens_text.h"

static void put_word(FILE *file, uint32_t word)
{
    const uint8_t bytes[4] = {(uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16),
                              (uint8_t)(word >> 24)};
    (void)fwrite(bytes, 1, sizeof bytes, file);
}

static void put_head(const struct rmap_mesh *mesh, FILE *file)
{
    enum { LONGEST = 200 };
    (void)fputs("ply\nformat binary_little_endian 1.0\ncomment unit mm\n", file);
    for (size_t i = 0; i < mesh->n_face; i++)
        if (mesh->face_name[i] && mesh->face_name[i][0]) {
            char name[LONGEST];
            rmap_lens_copy(name, sizeof name, mesh->face_name[i]);
            (void)fprintf(file, "comment face %zu %s\n", i, name);
        }
    (void)fprintf(file,
                  "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face %zu\nproperty list uchar int vertex_indices\nproperty int face\n"
                  "element surface %zu\nproperty int kind\nend_header\n",
                  mesh->n_vertex, mesh->n_triangle, mesh->n_face);
}

static enum rmap_status put(const void *context, FILE *file, struct rmap_error *err)
{
    const struct rmap_mesh *mesh = context;
    (void)err;
    put_head(mesh, file);
    for (size_t v = 0; v < mesh->n_vertex; v++)
        for (int k = 0; k < 3; k++) {
            uint32_t word;
            memcpy(&word, &mesh->vertex[v][k], sizeof word);
            put_word(file, word);
        }
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        (void)fputc(3, file);
        for (int k = 0; k < 3; k++)
            put_word(file, mesh->triangle[t][k]);
        put_word(file, mesh->face[t]);
    }
    for (size_t f = 0; f < mesh->n_face; f++) /* of kind 0: faces are their triangles */
        put_word(file, 0);
    return RMAP_OK;
}

enum rmap_status rmap_ply_write(const struct rmap_mesh *mesh, const char *path,
                                struct rmap_error *err)
{
    return rmap_whole_file_put(path, put, mesh, err);
}
