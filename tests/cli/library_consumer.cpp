// SPDX-License-Identifier: MIT
//
// Somebody else's program on libraymap: library_consumer MAP CRITERION COLUMN THREADS prints what
// test_library.py compares with the program's answers. Of the column, of doubles, floats or
// indices, the sum over the rows of the rays that match.
#include <raymap.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <vector>

namespace
{

class Map
{
  public:
    explicit Map(const char *path)
    {
        raymap_error error;
        if (raymap_open(path, &map_, &error) != RAYMAP_OK)
            throw std::runtime_error(error.text);
    }
    ~Map()
    {
        raymap_close(map_);
    }
    Map(const Map &) = delete;
    Map &operator=(const Map &) = delete;
    operator const raymap_map *() const
    {
        return map_;
    }

  private:
    raymap_map *map_ = nullptr;
};

struct Part {
    std::vector<double> sum; // of the blocks that it read
    uint64_t rows = 0;
    raymap_error error = raymap_error();
};

double sum_of(const void *data, uint64_t n, const raymap_column &column)
{
    double sum = 0;
    for (uint64_t i = 0; i < n; i++)
        sum += column.type == RAYMAP_F64   ? static_cast<const double *>(data)[i]
               : column.type == RAYMAP_F32 ? static_cast<const float *>(data)[i]
                                           : static_cast<const int32_t *>(data)[i];
    return sum;
}

void read(const raymap_map *map, char **words, size_t first, size_t last, Part *part)
{
    raymap_reader *reader = nullptr;
    raymap_column column;
    raymap_block block;
    if (raymap_reader_create(map, words[2], words[3], &reader, &part->error) != RAYMAP_OK)
        return;
    if (raymap_reader_column(reader, 0, &column) != RAYMAP_OK ||
        raymap_reader_column(reader, 1, &column) != RAYMAP_USAGE || raymap_data(reader, 0))
        std::abort();
    for (size_t i = first; i < last && raymap_read(reader, i, &block, &part->error) == RAYMAP_OK;
         i++) {
        const uint64_t n = block.rows[column.table];
        part->sum.push_back(
            sum_of(raymap_data(reader, 0), n * static_cast<uint64_t>(column.width), column));
        part->rows += n;
    }
    raymap_reader_destroy(reader);
}

// Of a call that makes no sense.
void refuse(const Map &map)
{
    raymap_reader *reader = nullptr;
    raymap_count count;
    raymap_error error;
    if (raymap_reader_create(map, nullptr, "ray/id", &reader, nullptr) != RAYMAP_OK ||
        raymap_read(reader, raymap_blocks(map), nullptr, &error) != RAYMAP_USAGE ||
        raymap_data(reader, 0) || raymap_count_rays(map, "hit(", &count, &error) != RAYMAP_INPUT)
        std::abort();
    raymap_reader_destroy(reader);
    std::printf("refused %s\n", error.text);
}

} // namespace

int main(int argc, char **argv)
try {
    if (argc != 5)
        return RAYMAP_USAGE;
    const Map map(argv[1]);
    const size_t n_thread = std::strtoul(argv[4], nullptr, 10), n = raymap_blocks(map);
    std::vector<Part> part(n_thread);
    std::vector<std::thread> thread;
    for (size_t t = 0; t < n_thread; t++)
        thread.emplace_back(read, static_cast<const raymap_map *>(map), argv, n * t / n_thread,
                            n * (t + 1) / n_thread, &part[t]);
    for (std::thread &one : thread)
        one.join();
    double sum = 0, metres = 0;
    uint64_t rows = 0;
    for (const Part &one : part) {
        if (one.error.status != RAYMAP_OK)
            throw std::runtime_error(one.error.text);
        for (double of_block : one.sum)
            sum += of_block;
        rows += one.rows;
    }
    raymap_count count;
    raymap_error error;
    if (raymap_count_rays(map, argv[2], &count, &error) != RAYMAP_OK)
        throw std::runtime_error(error.text);
    std::printf("rays %llu of %llu\nrows %llu\nsum %.17g\nflux %.17g %s\n",
                static_cast<unsigned long long>(count.rays),
                static_cast<unsigned long long>(raymap_rows(map, RAYMAP_RAY)),
                static_cast<unsigned long long>(rows), sum, count.flux, raymap_flux_unit(map));
    const char *unit = raymap_length_unit(map, &metres);
    std::printf("unit %s %g\n", unit, metres);
    for (size_t i = 0; const char *name = raymap_name(map, RAYMAP_OBJECT, i); i++)
        std::printf("object %s\n", name);
    refuse(map);
    return RAYMAP_OK;
} catch (const std::exception &error) {
    std::printf("%s\n", error.what());
    return 1;
}
