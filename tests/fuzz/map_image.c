/* SPDX-License-Identifier: MIT */
#include "map_image.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/codec/shuffle.h"
#include "io/file/seal.h"
#include "io/hdf5/h5.h"
#include "io/map/map_content.h"
#include "target.h"

enum { FOOTER = 32, SPARE = 1 << 20, CHANNELS = 3 /* RGB */ };

/* ---- loading: where the numbers lie ---- */

static void slurp(struct map_image *image, struct map_image_file *file)
{
    char path[256];
    (void)snprintf(path, sizeof path, "%s/%s", image->path, file->name);
    FILE *in = fopen(path, "rb");
    rmap_fuzz_demand(in && fseek(in, 0, SEEK_END) == 0, "opening the map's files");
    file->whole_nbytes = (size_t)ftell(in);
    file->cap = file->whole_nbytes + SPARE;
    file->whole = malloc(file->whole_nbytes);
    file->bytes = malloc(file->cap);
    rewind(in);
    rmap_fuzz_demand(file->whole && file->bytes &&
                         fread(file->whole, 1, file->whole_nbytes, in) == file->whole_nbytes,
                     "reading the map's files");
    (void)fclose(in);
    uint64_t n;
    memcpy(&n, file->whole + file->whole_nbytes - FOOTER, sizeof n);
    file->body_nbytes = file->whole_nbytes - FOOTER - (size_t)n * sizeof(struct rmap_range);
}

static void add_field(struct map_image *image, const char *name, size_t offset, size_t n,
                      size_t element_nbytes, size_t sum_at)
{
    if (n == 0 || image->n_field == MAP_IMAGE_FIELDS)
        return;
    struct map_image_field *field = &image->field[image->n_field++];
    *field = (struct map_image_field){image->n_file - 1, "", offset, n, element_nbytes, sum_at};
    (void)snprintf(field->name, sizeof field->name, "%s", name);
}

/* The place of 8 bytes in a file, or 0. */
static size_t find(const struct map_image_file *file, const void *bytes, size_t n, size_t from)
{
    for (size_t at = from; at + n <= file->whole_nbytes; at++)
        if (memcmp(file->whole + at, bytes, n) == 0)
            return at;
    return 0;
}

/* The place of a dataset's checksum: one that is not another's, for data may be equal. */
static size_t find_sum(const struct map_image *image, const struct map_image_file *file,
                       uint64_t sum)
{
    size_t at = find(file, &sum, sizeof sum, 0);
    for (int i = 0; at > 0 && i < image->n_field; i++)
        if (image->field[i].file == image->n_file - 1 && image->field[i].sum_at == at) {
            at = find(file, &sum, sizeof sum, at + 1);
            i = -1;
        }
    return at;
}

struct walk {
    struct map_image *image;
    hid_t file;
};

static herr_t visit_object(hid_t root, const char *name, const H5O_info_t *info, void *context)
{
    struct walk *walk = context;
    struct map_image_file *file = &walk->image->file[walk->image->n_file - 1];
    if (info->type != H5O_TYPE_DATASET)
        return 0;
    hid_t set = H5Dopen2(root, name, H5P_DEFAULT), type = H5Dget_type(set);
    haddr_t offset = H5Dget_offset(set);
    size_t nbytes = (size_t)H5Dget_storage_size(set), element = H5Tget_size(type);
    if (offset != HADDR_UNDEF && nbytes > 0) {
        if (H5Tget_class(type) == H5T_STRING)
            element = 1;
        add_field(walk->image, name, (size_t)offset, nbytes / element, element,
                  find_sum(walk->image, file, XXH3_64bits(file->whole + offset, nbytes)));
    }
    (void)H5Tclose(type);
    (void)H5Dclose(set);
    return 0;
}

/* An attribute message of version 1: u8 1, u8 0, u16 bytes of name, type and space, which follow
 * padded to 8 bytes each, then the value. */
static herr_t visit_attribute(hid_t root, const char *name, const H5A_info_t *info, void *context)
{
    struct walk *walk = context;
    struct map_image_file *file = &walk->image->file[walk->image->n_file - 1];
    size_t n = strlen(name) + 1;
    hid_t attribute = H5Aopen(root, name, H5P_DEFAULT), type = H5Aget_type(attribute);
    size_t element = H5Tget_class(type) == H5T_STRING ? 1 : H5Tget_size(type);
    for (size_t at = find(file, name, n, 8); at > 0; at = find(file, name, n, at + 1)) {
        uint16_t head[4];
        memcpy(head, file->whole + at - 8, sizeof head);
        if (head[0] != 1 || head[1] != n)
            continue;
        size_t value =
            at + ((n + 7) & ~(size_t)7) + ((head[2] + 7u) & ~7u) + ((head[3] + 7u) & ~7u);
        if (value + info->data_size <= file->whole_nbytes)
            add_field(walk->image, name, value, (size_t)info->data_size / element, element, 0);
        break;
    }
    (void)H5Tclose(type);
    (void)H5Aclose(attribute);
    return 0;
}

static void load_file(struct map_image *image, const char *name)
{
    char path[256];
    struct map_image_file *file = &image->file[image->n_file++];
    hsize_t first = 0;
    (void)snprintf(file->name, sizeof file->name, "%s", name);
    slurp(image, file);
    (void)snprintf(path, sizeof path, "%s/%s", image->path, name);
    struct walk walk = {image, H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT)};
    rmap_fuzz_demand(walk.file >= 0, "HDF5 opens what the program wrote");
    (void)H5Ovisit(walk.file, H5_INDEX_NAME, H5_ITER_INC, visit_object, &walk);
    hid_t root = H5Gopen2(walk.file, "/", H5P_DEFAULT);
    (void)H5Aiterate2(root, H5_INDEX_NAME, H5_ITER_INC, &first, visit_attribute, &walk);
    (void)H5Gclose(root);
    (void)H5Fclose(walk.file);
}

void map_image_load(struct map_image *image)
{
    char command[256], name[96];
    image->n_file = image->n_field = 0;
    load_file(image, "map.h5");
    (void)snprintf(command, sizeof command, "cd %s && ls -d shard-*/piece-*.h5 2>/dev/null",
                   image->path);
    FILE *list = popen(command, "r");
    rmap_fuzz_demand(list != NULL, "listing pieces");
    while (image->n_file < MAP_IMAGE_FILES && fgets(name, sizeof name, list)) {
        name[strcspn(name, "\n")] = 0;
        load_file(image, name);
    }
    (void)pclose(list);
    rmap_fuzz_demand(image->n_file > 1 && map_image_field(image, "chunk/offset") >= 0,
                     "a map with pieces and chunks");
    map_image_reset(image);
}

void map_image_fini(struct map_image *image)
{
    char command[128];
    for (int f = 0; f < image->n_file; f++) {
        free(image->file[f].bytes);
        free(image->file[f].whole);
    }
    (void)snprintf(command, sizeof command, "rm -rf %s", image->directory);
    rmap_fuzz_demand(system(command) == 0, "removing the map");
}

void map_image_reset(struct map_image *image)
{
    for (int f = 0; f < image->n_file; f++) {
        struct map_image_file *file = &image->file[f];
        memcpy(file->bytes, file->whole, file->whole_nbytes);
        file->nbytes = file->whole_nbytes;
        file->changed = 0;
    }
}

/* ---- changing ---- */

int map_image_field(const struct map_image *image, const char *name)
{
    for (int i = 0; i < image->n_field; i++)
        if (image->field[i].file == 0 && strcmp(image->field[i].name, name) == 0)
            return i;
    return -1;
}

uint64_t map_image_get(const struct map_image *image, int index, size_t element)
{
    const struct map_image_field *field = &image->field[index];
    uint64_t value = 0;
    size_t nbytes = field->element_nbytes < 8 ? field->element_nbytes : 8;
    if (element < field->n)
        memcpy(&value,
               image->file[field->file].bytes + field->offset + element * field->element_nbytes,
               nbytes);
    return value;
}

void map_image_set(struct map_image *image, int index, size_t element, uint64_t value)
{
    const struct map_image_field *field = &image->field[index];
    struct map_image_file *file = &image->file[field->file];
    size_t nbytes = field->element_nbytes < 8 ? field->element_nbytes : 8;
    if (element >= field->n || field->offset + field->n * field->element_nbytes > file->nbytes)
        return;
    memcpy(file->bytes + field->offset + element * field->element_nbytes, &value, nbytes);
    if (field->sum_at > 0 && field->sum_at + 8 <= file->nbytes) {
        uint64_t sum = XXH3_64bits(file->bytes + field->offset, field->n * field->element_nbytes);
        memcpy(file->bytes + field->sum_at, &sum, sizeof sum);
    }
    file->changed = 1;
}

static uint64_t of_chunk(const struct map_image *image, const char *name, size_t k)
{
    int field = map_image_field(image, name);
    return field < 0 ? 0 : map_image_get(image, field, k);
}

static void set_of_chunk(struct map_image *image, const char *name, size_t k, uint64_t value)
{
    int field = map_image_field(image, name);
    if (field >= 0)
        map_image_set(image, field, k, value);
}

/* The file that holds chunk k, by the pieces' runs of chunks. */
static struct map_image_file *file_of_chunk(struct map_image *image, size_t k, size_t *piece_ret)
{
    int first = map_image_field(image, "piece/first_chunk");
    for (size_t p = image->field[first].n; p-- > 0;) {
        uint64_t from = map_image_get(image, first, p);
        if (k < from || k - from >= of_chunk(image, "piece/n_chunk", p))
            continue;
        char name[64];
        (void)snprintf(name, sizeof name, "shard-%05d/piece-%05d.h5",
                       (int)of_chunk(image, "piece/shard", p),
                       (int)of_chunk(image, "piece/number", p));
        *piece_ret = p;
        for (int f = 1; f < image->n_file; f++)
            if (strcmp(image->file[f].name, name) == 0)
                return &image->file[f];
    }
    return NULL;
}

/* Its bytes, if the index still points inside the file. */
static uint8_t *bytes_of_chunk(struct map_image *image, size_t k, size_t *piece, size_t *nbytes,
                               struct map_image_file **file_ret)
{
    struct map_image_file *file = file_of_chunk(image, k, piece);
    uint64_t offset = of_chunk(image, "chunk/offset", k);
    *nbytes = (size_t)of_chunk(image, "chunk/nbytes", k);
    *file_ret = file;
    if (!file || offset > file->nbytes || *nbytes > file->nbytes - offset || *nbytes < 8)
        return NULL;
    return file->bytes + offset;
}

void map_image_poke_chunk(struct map_image *image, size_t k, size_t at, uint8_t value)
{
    size_t nbytes, piece;
    struct map_image_file *file;
    uint8_t *stored = bytes_of_chunk(image, k, &piece, &nbytes, &file);
    if (!stored)
        return;
    stored[at % (nbytes - 4)] = value;
    uint32_t sum = rmap_fletcher32(stored, nbytes - 4);
    memcpy(stored + nbytes - 4, &sum, sizeof sum);
    set_of_chunk(image, "chunk/checksum", k, rmap_checksum(stored, nbytes));
    file->changed = 1;
}

/* What chunk k holds, as long as the index says something sensible. */
static const struct rmap_stream_info *stream_of_chunk(const struct map_image *image, size_t k,
                                                      size_t piece)
{
    uint64_t encoding = of_chunk(image, "piece/encoding", piece);
    uint64_t stream = of_chunk(image, "chunk/stream", k);
    const struct rmap_layout *layout =
        encoding < RMAP_ENCODING_COUNT
            ? rmap_layout_of((enum rmap_encoding)encoding, RMAP_COLOUR_RGB)
            : NULL;
    return layout && stream < (uint64_t)layout->n_stream ? &layout->stream[stream] : NULL;
}

static int decode(const uint8_t *stored, size_t nbytes, size_t n, size_t element, uint8_t *plane)
{
    struct rmap_decoder *decoder = NULL;
    uint8_t *copy = calloc(nbytes + RMAP_INFLATE_SLACK, 1);
    rmap_fuzz_demand(copy && rmap_decoder_create(&decoder, NULL) == RMAP_OK, "a decoder");
    memcpy(copy, stored, nbytes);
    enum rmap_status st = rmap_decoder_planes(decoder, copy, nbytes, n, element, plane, NULL);
    rmap_decoder_destroy(decoder);
    free(copy);
    return st == RMAP_OK;
}

/* The chunk goes behind the file's end: there is room, and the index says where. */
static void append_chunk(struct map_image *image, size_t k, size_t piece,
                         struct map_image_file *file, const uint8_t *stored, size_t nbytes)
{
    if (file->nbytes + nbytes > file->cap)
        return;
    memcpy(file->bytes + file->nbytes, stored, nbytes);
    set_of_chunk(image, "chunk/offset", k, file->nbytes);
    set_of_chunk(image, "chunk/nbytes", k, nbytes);
    set_of_chunk(image, "chunk/checksum", k, rmap_checksum(stored, nbytes));
    file->nbytes += nbytes;
    set_of_chunk(image, "piece/nbytes", piece, file->nbytes);
    file->changed = 1;
}

void map_image_set_in_chunk(struct map_image *image, size_t k, size_t row, uint64_t value)
{
    static uint8_t plane[RMAP_CHUNK_ROWS * 24], raw[RMAP_CHUNK_ROWS * 24];
    size_t nbytes, piece = 0;
    struct map_image_file *file;
    struct rmap_encoder *encoder = NULL;
    const uint8_t *stored = bytes_of_chunk(image, k, &piece, &nbytes, &file);
    const struct rmap_stream_info *stream = stream_of_chunk(image, k, piece);
    if (!stored || !stream || rmap_stream_row_nbytes(stream, CHANNELS) > 24)
        return;
    size_t element = rmap_element_nbytes(stream->element);
    size_t n = RMAP_CHUNK_ROWS * rmap_stream_width(stream, CHANNELS);
    if (!decode(stored, nbytes, n, element, plane))
        return;
    rmap_unshuffle(plane, n, 0, n, element, raw);
    memcpy(raw + row % n * element, &value, element);
    uint8_t *out = malloc(rmap_codec_bound(n, element));
    rmap_fuzz_demand(out && rmap_encoder_create(&encoder, NULL) == RMAP_OK &&
                         rmap_encoder_encode(encoder, raw, n, n, element, out, &nbytes, NULL) ==
                             RMAP_OK,
                     "encoding");
    append_chunk(image, k, piece, file, out, nbytes);
    rmap_encoder_destroy(encoder);
    free(out);
}

void map_image_cut(struct map_image *image, int index, size_t nbytes)
{
    struct map_image_file *file = &image->file[index];
    int shard = 0, number = 0, shards = map_image_field(image, "piece/shard");
    if (nbytes >= file->nbytes || sscanf(file->name, "shard-%d/piece-%d.h5", &shard, &number) != 2)
        return;
    for (size_t p = 0; p < image->field[shards].n; p++)
        if ((int)map_image_get(image, shards, p) == shard &&
            (int)of_chunk(image, "piece/number", p) == number)
            set_of_chunk(image, "piece/nbytes", p, nbytes);
    file->nbytes = nbytes;
    file->changed = 1;
}

/* ---- storing ---- */

/* The footer's hashes over the bytes as they are now. */
static void seal(struct map_image_file *file)
{
    XXH3_state_t *state = XXH3_createState();
    struct rmap_range range;
    uint64_t n, at = 0;
    if (file->nbytes < file->whole_nbytes) {
        XXH3_freeState(state);
        return;
    }
    uint8_t *ranges = file->bytes + file->body_nbytes;
    uint8_t *footer = file->bytes + file->whole_nbytes - FOOTER;
    memcpy(&n, footer, sizeof n);
    XXH3_64bits_reset(state);
    for (uint64_t i = 0; i < n; i++) {
        memcpy(&range, ranges + i * sizeof range, sizeof range);
        XXH3_64bits_update(state, file->bytes + at, (size_t)(range.offset - at));
        at = range.offset + range.nbytes;
    }
    XXH3_64bits_update(state, file->bytes + at, (size_t)(file->body_nbytes - at));
    uint64_t rest = XXH3_64bits_digest(state);
    memcpy(footer + 8, &rest, sizeof rest);
    XXH3_freeState(state);
    uint64_t own = XXH3_64bits(ranges, (size_t)n * sizeof range + 16);
    memcpy(footer + 16, &own, sizeof own);
}

void map_image_store(struct map_image *image)
{
    for (int f = 0; f < image->n_file; f++) {
        char path[256];
        struct map_image_file *file = &image->file[f];
        if (file->changed)
            seal(file);
        if (!file->changed && !file->on_disk_differs)
            continue;
        (void)snprintf(path, sizeof path, "%s/%s", image->path, file->name);
        int fd = open(path, O_WRONLY | O_TRUNC);
        rmap_fuzz_demand(fd >= 0 && write(fd, file->bytes, file->nbytes) == (ssize_t)file->nbytes &&
                             close(fd) == 0,
                         "writing the map's files");
        file->on_disk_differs = file->changed;
    }
}
