// SPDX-License-Identifier: MIT
//
// A CAD file as the converter holds it: shapes (each once, meshed, with the true surface of every
// face) and the tree of parts that place them. Lengths are mm, angles radians, colours sRGB from 0
// to 1.
#ifndef CAD_ASSEMBLY_HPP
#define CAD_ASSEMBLY_HPP

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>
#include <gp_XYZ.hxx>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cad
{

using Color = std::array<double, 3>;

enum class Kind { none, plane, cylinder, cone, sphere, torus };
const char *name_of(Kind kind);

// What the face is a part of. `origin` and `axis`: a point and the normal; a point on the axis and
// the axis; the middle. radius1: of cylinder and sphere, of the cone in the plane through the
// origin, of the torus the great one. radius2: half the cone's angle, the radius growing along the
// axis when > 0; the small radius of the torus.
struct Surface {
    Kind kind = Kind::none;
    gp_XYZ origin, axis{0, 0, 1};
    double radius1 = 0, radius2 = 0;
};

struct Face {
    std::string name;
    std::optional<Color> color;
    Surface surface;
    double area = 0;
    gp_XYZ centroid;     // of the area
    bool hollow = false; // outward is towards the axis or the middle; of a plane against its normal
    TopoDS_Face brep;
};

struct Mesh {
    std::vector<gp_XYZ> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> face; // of each triangle
};

struct Shape {
    std::string name, hash, form;
    bool closed = false;
    double volume = 0, area = 0, chord = 0;
    gp_XYZ centroid;
    std::array<double, 3> moments{}; // principal ones of the volume (area if open), ascending
    gp_XYZ lower, upper;
    std::vector<Face> faces;
    Mesh mesh;
    TopoDS_Shape brep;
};

struct Part {
    std::string id, name, material;
    std::optional<Color> color;
    gp_Trsf place;  // in the parent's frame
    int shape = -1; // of Assembly::shapes; or parts
    std::vector<Part> parts;
};

struct Finding {
    std::string part, text;
    bool error = false;
};

struct Touching {
    std::string a, b;
    double area;
};

struct Assembly {
    std::string source, schema, unit, writer;
    std::vector<Shape> shapes;
    std::vector<Part> parts;
    std::vector<Touching> touching;
    std::vector<Finding> findings;

    void warn(const std::string &part, const std::string &text);
};

struct Options {
    std::string input, folder;
    double chord = 0;   // mm; 0: chord_of_size of each shape's diagonal
    double angle = 10;  // degrees
    double seconds = 0; // after which it is given up; 0: an hour or more
    bool quiet = false, touching = true;
    static constexpr double chord_of_size = 1e-3;
};

// What a file is refused for; the text names it.
struct Refused {
    std::string text;
    int status = 3;
};

} // namespace cad

#endif
