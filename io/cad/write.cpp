// SPDX-License-Identifier: MIT
#include "write.hpp"

#include <jansson.h>

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <set>

namespace cad
{

namespace
{

// A new file, complete or an exception.
class NewFile
{
  public:
    explicit NewFile(const std::string &path) : name(path)
    {
        const int handle =
            open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (handle < 0 || !(file = fdopen(handle, "wb")))
            fail();
    }
    NewFile(const NewFile &) = delete;
    NewFile &operator=(const NewFile &) = delete;
    ~NewFile()
    {
        if (file)
            std::fclose(file);
    }
    void put(const void *data, std::size_t n)
    {
        if (n > 0 && std::fwrite(data, 1, n, file) != n)
            fail();
    }
    void put(const std::string &text)
    {
        put(text.data(), text.size());
    }
    template <class Number>
    void put_number(Number value) // little-endian, as the machines that the program runs on
    {
        put(&value, sizeof value);
    }
    void close()
    {
        const int bad = std::fclose(file);
        file = nullptr;
        if (bad)
            fail();
    }

  private:
    std::string name;
    std::FILE *file = nullptr;

    [[noreturn]] void fail() const
    {
        throw Refused{name + ": " + std::strerror(errno), 5};
    }
};

void make_folder(const std::string &folder)
{
    if (mkdir(folder.c_str(), 0777) == 0)
        return;
    const std::unique_ptr<DIR, int (*)(DIR *)> open_folder(
        errno == EEXIST ? opendir(folder.c_str()) : nullptr, closedir);
    if (!open_folder)
        throw Refused{folder + ": " + std::strerror(errno), 5};
    while (const dirent *entry = readdir(open_folder.get()))
        if (std::strcmp(entry->d_name, ".") != 0 && std::strcmp(entry->d_name, "..") != 0)
            throw Refused{folder + ": there is something in it: give a new folder", 2};
}

std::string file_name(const std::string &name, std::set<std::string> &taken)
{
    std::string stem;
    for (const char c : name) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
        if (stem.empty() && c == '-') /* an option, to other programs */
            continue;
        if (stem.size() < 60 && (plain || (!stem.empty() && stem.back() != '_')))
            stem += plain ? static_cast<char>(std::tolower(c)) : '_';
    }
    if (stem.empty())
        stem = "shape";
    std::string file = stem;
    for (int i = 2; !taken.insert(file).second; ++i)
        file = stem + "-" + std::to_string(i);
    return file + ".ply";
}

unsigned char byte_of(double value)
{
    return static_cast<unsigned char>(std::lround(255 * std::min(1.0, std::max(0.0, value))));
}

void write_ply(const std::string &path, const Shape &shape)
{
    NewFile file(path);
    const Mesh &mesh = shape.mesh;
    std::string head = "ply\nformat binary_little_endian 1.0\ncomment unit mm\n";
    for (std::size_t f = 0; f < shape.faces.size(); ++f) {
        std::string name = shape.faces[f].name;
        for (char &c : name)
            if (static_cast<unsigned char>(c) < 0x20)
                c = ' ';
        if (!name.empty())
            head += "comment face " + std::to_string(f) + " " + name + "\n";
    }
    head += "element vertex " + std::to_string(mesh.vertices.size()) +
            "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
            std::to_string(mesh.triangles.size()) +
            "\nproperty list uchar int vertex_indices\nproperty int face\nelement surface " +
            std::to_string(shape.faces.size()) + "\nproperty int kind\n";
    for (const char *name : {"ox", "oy", "oz", "ax", "ay", "az", "r1", "r2"})
        head += std::string("property double ") + name + "\n";
    for (const char *name : {"red", "green", "blue"})
        head += std::string("property uchar ") + name + "\n";
    file.put(head + "end_header\n");
    for (const gp_XYZ &at : mesh.vertices)
        for (int i = 1; i <= 3; ++i)
            file.put_number(at.Coord(i));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        file.put_number(static_cast<unsigned char>(3));
        for (const std::uint32_t corner : mesh.triangles[t])
            file.put_number(static_cast<std::int32_t>(corner));
        file.put_number(static_cast<std::int32_t>(mesh.face[t]));
    }
    for (const Face &face : shape.faces) {
        file.put_number(static_cast<std::int32_t>(face.surface.kind));
        for (const gp_XYZ *three : {&face.surface.origin, &face.surface.axis})
            for (int i = 1; i <= 3; ++i)
                file.put_number(three->Coord(i));
        file.put_number(face.surface.radius1);
        file.put_number(face.surface.radius2);
        for (const double value : face.color.value_or(Color{1, 1, 1}))
            file.put_number(byte_of(value));
    }
    file.close();
}

json_t *string_json(const std::string &text)
{
    return json_stringn_nocheck(text.data(), text.size());
}

json_t *numbers_json(const double *values, std::size_t n)
{
    json_t *array = json_array();
    for (std::size_t i = 0; i < n; ++i)
        json_array_append_new(array, json_real(values[i]));
    return array;
}

json_t *color_json(const std::optional<Color> &color)
{
    return color ? numbers_json(color->data(), 3) : json_null();
}

json_t *point_json(const gp_XYZ &at)
{
    const double values[3] = {at.X(), at.Y(), at.Z()};
    return numbers_json(values, 3);
}

json_t *shape_json(const Shape &shape, std::size_t number, const std::string &file)
{
    json_t *faces = json_array();
    for (const Face &face : shape.faces)
        json_array_append_new(faces, json_pack("{so so ss sf so}", "name", string_json(face.name),
                                               "color", color_json(face.color), "surface",
                                               name_of(face.surface.kind), "area", face.area,
                                               "middle", point_json(face.centroid)));
    return json_pack("{so ss so sb sf sf s[oo] sf ss ss so}", "id",
                     string_json("s" + std::to_string(number)), "file", file.c_str(), "name",
                     string_json(shape.name), "closed", shape.closed ? 1 : 0, "volume",
                     shape.volume, "area", shape.area, "bounds", point_json(shape.lower),
                     point_json(shape.upper), "chord", shape.chord, "hash", shape.hash.c_str(),
                     "form", shape.form.c_str(), "faces", faces);
}

json_t *part_json(const Part &part)
{
    json_t *matrix = json_array();
    for (int i = 1; i <= 3; ++i)
        for (int j = 1; j <= 4; ++j)
            json_array_append_new(matrix, json_real(part.place.Value(i, j)));
    json_t *out = json_pack("{so so so so so}", "id", string_json(part.id), "name",
                            string_json(part.name), "color", color_json(part.color), "material",
                            part.material.empty() ? json_null() : string_json(part.material),
                            "matrix", matrix);
    if (part.shape >= 0) {
        json_object_set_new(out, "shape", string_json("s" + std::to_string(part.shape + 1)));
        return out;
    }
    json_t *parts = json_array();
    for (const Part &child : part.parts)
        json_array_append_new(parts, part_json(child));
    json_object_set_new(out, "parts", parts);
    return out;
}

} // namespace

void write_assembly(const Options &options, const Assembly &assembly)
{
    make_folder(options.folder);
    std::set<std::string> taken;
    json_t *shapes = json_array(), *parts = json_array(), *touching = json_array(),
           *findings = json_array();
    for (std::size_t i = 0; i < assembly.shapes.size(); ++i) {
        const std::string file = file_name(assembly.shapes[i].name, taken);
        write_ply(options.folder + "/" + file, assembly.shapes[i]);
        json_array_append_new(shapes, shape_json(assembly.shapes[i], i + 1, file));
    }
    for (const Part &part : assembly.parts)
        json_array_append_new(parts, part_json(part));
    for (const Touching &pair : assembly.touching)
        json_array_append_new(
            touching, json_pack("[oof]", string_json(pair.a), string_json(pair.b), pair.area));
    for (const Finding &finding : assembly.findings)
        json_array_append_new(
            findings, json_pack("{ss so so}", "severity", "warning", "part",
                                finding.part.empty() ? json_null() : string_json(finding.part),
                                "text", string_json(finding.text)));
    json_t *whole = json_pack(
        "{ss si so so ss so so so sf so so so so}", "format", "raymap-assembly", "version", 1,
        "source", string_json(assembly.source), "schema", string_json(assembly.schema), "unit",
        "mm", "file_unit", string_json(assembly.unit), "writer", string_json(assembly.writer),
        "chord", options.chord > 0 ? json_real(options.chord) : json_null(), "angle", options.angle,
        "shapes", shapes, "parts", parts, "touching", touching, "findings", findings);
    const std::unique_ptr<char, decltype(&free)> text(
        whole ? json_dumps(whole, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : nullptr, free);
    json_decref(whole);
    if (!text)
        throw Refused{options.folder + "/assembly.json: no memory for it", 5};
    NewFile file(options.folder + "/assembly.json");
    file.put(text.get());
    file.put("\n");
    file.close();
}

} // namespace cad
