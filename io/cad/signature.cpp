// SPDX-License-Identifier: MIT
//
// What a body is, in numbers that another revision of the file has again whatever the order of its
// faces; and how a copy of it lies.
#include "bodies.hpp"
#include "surface.hpp"

#include <gp_Ax3.hxx>
#include <xxhash.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace cad
{

// Numbers are told as multiples of a quantum. Whole and half multiples, which drawings are full of,
// lie in the middle of what is rounded alike.
class Teller
{
  public:
    explicit Teller(double length) : size(length)
    {
    }
    void tell(double value, int power = 1)
    {
        char text[32];
        const double quantum = 1e-7 * std::pow(size, power);
        std::snprintf(text, sizeof text, "%.0f ", std::floor(value / quantum + 0.381966) + 0.0);
        line += text;
    }
    void tell(const gp_XYZ &value, int power = 1)
    {
        for (int i = 1; i <= 3; ++i)
            tell(value.Coord(i), power);
    }
    void tell_word(const std::string &word)
    {
        line += word + ' ';
    }
    void end()
    {
        lines.push_back(line);
        line.clear();
    }
    std::string hash()
    {
        std::sort(lines.begin(), lines.end());
        std::string all;
        for (const std::string &text : lines)
            all += text + '\n';
        const XXH128_hash_t sum = XXH3_128bits(all.data(), all.size());
        char text[40];
        std::snprintf(text, sizeof text, "%016" PRIx64 "%016" PRIx64,
                      static_cast<std::uint64_t>(sum.high64),
                      static_cast<std::uint64_t>(sum.low64));
        return text;
    }

  private:
    double size;
    std::string line;
    std::vector<std::string> lines;
};

// One of a power of two, so that noise in the last digits changes no quantum.
static double size_of(const Shape &shape)
{
    const double length = std::sqrt(shape.area);
    return length > 0 ? std::exp2(std::ceil(std::log2(length) + 0.1234)) : 1;
}

static void tell_face(Teller &teller, const Face &face)
{
    teller.tell_word(name_of(face.surface.kind));
    teller.tell_word(face.hollow && face.surface.kind != Kind::plane ? "hollow" : "");
    teller.tell(face.surface.radius1);
    teller.tell(face.surface.radius2, face.surface.kind == Kind::cone ? 0 : 1);
    teller.tell(face.area, 2);
}

void sign(Shape &shape)
{
    const double size = size_of(shape);
    Teller form(size), here(size);
    for (const Face &face : shape.faces) {
        // A cone's radius depends on where its axis is begun: its angle tells it.
        Face told = face;
        if (told.surface.kind == Kind::cone) {
            told.surface.radius1 = 0;
            told.surface.radius2 = std::abs(told.surface.radius2);
        }
        tell_face(form, told);
        form.tell((face.centroid - shape.centroid).Modulus());
        form.end();
        tell_face(here, told);
        here.tell(face.centroid);
        here.end();
    }
    for (Teller *teller : {&form, &here}) {
        teller->tell_word(shape.closed ? "closed" : "open");
        teller->tell(shape.volume, 3);
        for (const double moment : shape.moments)
            teller->tell(moment, shape.closed ? 5 : 4);
    }
    form.end();
    here.tell(shape.centroid);
    here.end();
    shape.form = form.hash();
    shape.hash = here.hash();
}

// Points and directions that a body has of itself, in the order of what they are.
struct Feature {
    std::string what;
    gp_XYZ at;
    const Face *face;
};

static std::vector<Feature> features_of(const Shape &shape)
{
    std::vector<Feature> features;
    for (const Face &face : shape.faces) {
        char text[160];
        const gp_XYZ from = face.centroid - shape.centroid;
        const double quantum = 1e-5 * size_of(shape);
        std::snprintf(text, sizeof text, "%s %d %.0f %.0f", name_of(face.surface.kind),
                      face.surface.kind != Kind::plane && face.hollow,
                      std::round(face.area / (quantum * size_of(shape))),
                      std::round(from.Modulus() / quantum));
        features.push_back({text, from, &face});
    }
    std::sort(features.begin(), features.end(),
              [](const Feature &a, const Feature &b) { return a.what < b.what; });
    return features;
}

// Whether every face of a, placed, is a face of b: surface, area and middle; and corners of a lie
// on b's surfaces.
static bool matches(const Shape &a, const Shape &b, const gp_Trsf &place)
{
    const double tolerance = 1e-7 * size_of(a);
    std::vector<bool> taken(b.faces.size());
    for (const Face &face : a.faces) {
        gp_XYZ centroid = face.centroid;
        place.Transforms(centroid);
        const Surface surface = placed(face.surface, place);
        bool found = false;
        for (std::size_t i = 0; i < b.faces.size() && !found; ++i) {
            const Face &other = b.faces[i];
            if (taken[i] || (other.centroid - centroid).Modulus() > tolerance ||
                std::abs(other.area - face.area) > tolerance * size_of(a) ||
                !same_surface(surface, other.surface, tolerance, 1e-9))
                continue;
            found = taken[i] = true;
        }
        if (!found)
            return false;
    }
    return true;
}

// The frame of three points; false where they lie on a line.
static bool frame_of(const gp_XYZ &p, const gp_XYZ &q, gp_XYZ &x, gp_XYZ &y, gp_XYZ &z)
{
    z = p ^ q;
    if (z.Modulus() <= 1e-6 * p.Modulus() * q.Modulus() || p.Modulus() == 0)
        return false;
    x = p.Normalized();
    z.Normalize();
    y = z ^ x;
    return true;
}

static gp_Trsf between(const gp_XYZ from[3], const gp_XYZ to[3], const gp_XYZ &old_middle,
                       const gp_XYZ &middle)
{
    // rows of M = sum of to_k from_k^T
    double m[3][3] = {};
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                m[i][j] += to[k].Coord(i + 1) * from[k].Coord(j + 1);
    const gp_XYZ rows[3] = {
        {m[0][0], m[0][1], m[0][2]}, {m[1][0], m[1][1], m[1][2]}, {m[2][0], m[2][1], m[2][2]}};
    const gp_XYZ t =
        middle - gp_XYZ(rows[0] * old_middle, rows[1] * old_middle, rows[2] * old_middle);
    gp_Trsf place;
    place.SetValues(m[0][0], m[0][1], m[0][2], t.X(), m[1][0], m[1][1], m[1][2], t.Y(), m[2][0],
                    m[2][1], m[2][2], t.Z());
    return place;
}

bool copy_of(const Shape &a, const Shape &b, gp_Trsf &place)
{
    if (a.form != b.form || a.faces.size() != b.faces.size() || !a.closed)
        return false;
    // A freeform face is known by area and middle alone, which is not enough.
    for (const Face &face : a.faces)
        if (face.surface.kind == Kind::none)
            return false;
    gp_Trsf moved;
    moved.SetTranslation(gp_Vec(b.centroid - a.centroid));
    if (matches(a, b, moved)) {
        place = moved;
        return true;
    }
    const std::vector<Feature> of_a = features_of(a), of_b = features_of(b);
    gp_XYZ from[3], to[3];
    std::size_t first = 0, second = 0;
    bool framed = false;
    for (; first < of_a.size() && of_a[first].at.Modulus() < 1e-6 * size_of(a); ++first)
        ;
    for (second = first + 1; second < of_a.size() && !framed; ++second)
        framed = frame_of(of_a[first].at, of_a[second].at, from[0], from[1], from[2]);
    if (first >= of_a.size())
        return false;
    int tried = 0;
    for (const Feature &p : of_b) {
        if (p.what != of_a[first].what)
            continue;
        if (!framed) { // all on one axis: any turn about it will do
            const gp_XYZ aside = std::abs(of_a[first].at.X()) < 0.9 * of_a[first].at.Modulus()
                                     ? gp_XYZ(1, 0, 0)
                                     : gp_XYZ(0, 1, 0);
            const gp_XYZ besides =
                std::abs(p.at.X()) < 0.9 * p.at.Modulus() ? gp_XYZ(1, 0, 0) : gp_XYZ(0, 1, 0);
            frame_of(of_a[first].at, aside, from[0], from[1], from[2]);
            frame_of(p.at, besides, to[0], to[1], to[2]);
            place = between(from, to, a.centroid, b.centroid);
            if (matches(a, b, place))
                return true;
            continue;
        }
        for (const Feature &q : of_b) {
            if (q.what != of_a[second - 1].what || !frame_of(p.at, q.at, to[0], to[1], to[2]))
                continue;
            for (const bool mirrored : {false, true}) {
                if (++tried > 200)
                    return false;
                if (mirrored)
                    to[2].Reverse();
                place = between(from, to, a.centroid, b.centroid);
                if (matches(a, b, place))
                    return true;
            }
        }
    }
    return false;
}

} // namespace cad
