// SPDX-License-Identifier: MIT
#include "touching.hpp"

#include "surface.hpp"

#include <BRep_Tool.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>

#include <algorithm>
#include <cmath>

namespace cad
{

namespace
{

constexpr double gap = 1e-4; // mm: faces nearer than that touch (a fifth of a wavelength)
constexpr double tilt = 1e-6;

struct Box {
    gp_XYZ lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};

    void add(const gp_XYZ &at)
    {
        for (int i = 1; i <= 3; ++i) {
            lower.SetCoord(i, std::min(lower.Coord(i), at.Coord(i)));
            upper.SetCoord(i, std::max(upper.Coord(i), at.Coord(i)));
        }
    }
    bool meets(const Box &other, double margin) const
    {
        for (int i = 1; i <= 3; ++i)
            if (lower.Coord(i) > other.upper.Coord(i) + margin ||
                other.lower.Coord(i) > upper.Coord(i) + margin)
                return false;
        return true;
    }
};

using Triangle = std::array<gp_XYZ, 3>;

struct PlacedFace {
    Box box;
    Surface surface;
    std::vector<Triangle> triangles;
};

struct Placed {
    const Part *part;
    gp_Trsf place;
    Box box;
    std::vector<PlacedFace> faces; // when first asked for
};

void flatten(const std::vector<Part> &parts, const gp_Trsf &above, std::vector<Placed> &out)
{
    for (const Part &part : parts) {
        const gp_Trsf place = above * part.place;
        if (part.shape >= 0)
            out.push_back({&part, place, {}, {}});
        flatten(part.parts, place, out);
    }
}

gp_XYZ moved(gp_XYZ at, const gp_Trsf &place)
{
    place.Transforms(at);
    return at;
}

void place_faces(Placed &placed_part, const Shape &shape)
{
    if (!placed_part.faces.empty())
        return;
    placed_part.faces.resize(shape.faces.size());
    for (std::size_t f = 0; f < shape.faces.size(); ++f)
        placed_part.faces[f].surface = placed(shape.faces[f].surface, placed_part.place);
    const bool mirrored = placed_part.place.IsNegative();
    for (std::size_t t = 0; t < shape.mesh.triangles.size(); ++t) {
        PlacedFace &face = placed_part.faces[shape.mesh.face[t]];
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            triangle[k] = moved(shape.mesh.vertices[shape.mesh.triangles[t][k]], placed_part.place);
            face.box.add(triangle[k]);
        }
        if (mirrored)
            std::swap(triangle[1], triangle[2]);
        face.triangles.push_back(triangle);
    }
}

gp_XYZ area_vector(const Triangle &t)
{
    return ((t[1] - t[0]) ^ (t[2] - t[0])) / 2;
}

// The area of b's shadow on a, within a: b's corners in the plane of a, cut by its sides
// (Sutherland and Hodgman, 1974).
double shadow(const Triangle &a, const Triangle &b)
{
    const gp_XYZ area = area_vector(a);
    if (area.Modulus() == 0 || area * area_vector(b) >= 0)
        return 0;
    const gp_XYZ normal = area.Normalized();
    std::vector<gp_XYZ> polygon;
    for (const gp_XYZ &corner : b)
        polygon.push_back(corner - normal * ((corner - a[0]) * normal));
    for (std::size_t k = 0; k < 3 && !polygon.empty(); ++k) {
        const gp_XYZ inward = normal ^ (a[(k + 1) % 3] - a[k]);
        std::vector<gp_XYZ> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const gp_XYZ &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
            const double at_p = (p - a[k]) * inward, at_q = (q - a[k]) * inward;
            if (at_p >= 0)
                kept.push_back(p);
            if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0))
                kept.push_back(p + (q - p) * (at_p / (at_p - at_q)));
        }
        polygon.swap(kept);
    }
    gp_XYZ sum(0, 0, 0);
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        sum += (polygon[i] - polygon[0]) ^ (polygon[i + 1] - polygon[0]);
    return sum.Modulus() / 2;
}

double overlap(const PlacedFace &a, const PlacedFace &b, double chord)
{
    struct Entry {
        Box box;
        const Triangle *triangle;
    };
    const auto near = [chord](const PlacedFace &face, const Box &other) {
        std::vector<Entry> entries;
        for (const Triangle &triangle : face.triangles) {
            Entry entry{{}, &triangle};
            for (const gp_XYZ &corner : triangle)
                entry.box.add(corner);
            if (entry.box.meets(other, chord))
                entries.push_back(entry);
        }
        std::sort(entries.begin(), entries.end(),
                  [](const Entry &p, const Entry &q) { return p.box.lower.X() < q.box.lower.X(); });
        return entries;
    };
    const std::vector<Entry> of_a = near(a, b.box), of_b = near(b, a.box);
    double widest = 0, area = 0;
    for (const Entry &entry : of_b)
        widest = std::max(widest, entry.box.upper.X() - entry.box.lower.X());
    for (const Entry &p : of_a) {
        auto q =
            std::lower_bound(of_b.begin(), of_b.end(), p.box.lower.X() - widest - chord,
                             [](const Entry &entry, double x) { return entry.box.lower.X() < x; });
        for (; q != of_b.end() && q->box.lower.X() <= p.box.upper.X() + chord; ++q)
            if (p.box.meets(q->box, chord))
                area += shadow(*p.triangle, *q->triangle);
    }
    return area;
}

// Freeform faces: corners of a's triangles near b lie on b's surface, nine of them at most.
bool same_freeform(const PlacedFace &a, const Placed &of_b, const Face &b, const Box &box_b)
{
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(b.brep);
    const gp_Trsf back = of_b.place.Inverted();
    std::vector<gp_XYZ> points;
    for (const Triangle &triangle : a.triangles) {
        const Box at{triangle[0], triangle[0]};
        if (at.meets(box_b, 0))
            points.push_back(triangle[0]);
    }
    const std::size_t step = std::max<std::size_t>(1, points.size() / 9);
    for (std::size_t i = 0; i < points.size(); i += step) {
        const GeomAPI_ProjectPointOnSurf nearest(gp_Pnt(moved(points[i], back)), surface);
        if (nearest.NbPoints() == 0 || nearest.LowerDistance() > gap)
            return false;
    }
    return !points.empty();
}

double touching_area(const Placed &a, const Placed &b, const Shape &of_a, const Shape &of_b)
{
    const double chord = of_a.chord + of_b.chord + gap;
    double area = 0;
    for (std::size_t i = 0; i < a.faces.size(); ++i) {
        const PlacedFace &face = a.faces[i];
        if (!face.box.meets(b.box, gap))
            continue;
        for (std::size_t j = 0; j < b.faces.size(); ++j) {
            const PlacedFace &other = b.faces[j];
            if (!face.box.meets(other.box, gap) ||
                !same_surface(face.surface, other.surface, gap, tilt))
                continue;
            if (face.surface.kind == Kind::none &&
                !same_freeform(face, b, of_b.faces[j], other.box))
                continue;
            area += overlap(face, other, chord);
        }
    }
    return area;
}

} // namespace

void find_touching(Assembly &assembly, Progress &progress)
{
    std::vector<Placed> parts;
    flatten(assembly.parts, gp_Trsf(), parts);
    std::vector<std::size_t> order;
    for (Placed &part : parts) {
        for (const gp_XYZ &at :
             assembly.shapes[static_cast<std::size_t>(part.part->shape)].mesh.vertices)
            part.box.add(moved(at, part.place));
        order.push_back(order.size());
    }
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return parts[a].box.lower.X() < parts[b].box.lower.X();
    });
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && parts[order[j]].box.lower.X() <=
                                                            parts[order[i]].box.upper.X() + gap;
             ++j)
            if (parts[order[i]].box.meets(parts[order[j]].box, gap))
                pairs.push_back(std::minmax(order[i], order[j]));
    std::sort(pairs.begin(), pairs.end());
    std::size_t done = 0;
    for (const auto &[i, j] : pairs) {
        progress.step("looking for touching faces", ++done, pairs.size());
        Placed &a = parts[i], &b = parts[j];
        const Shape &of_a = assembly.shapes[static_cast<std::size_t>(a.part->shape)];
        const Shape &of_b = assembly.shapes[static_cast<std::size_t>(b.part->shape)];
        place_faces(a, of_a);
        place_faces(b, of_b);
        const double area = touching_area(a, b, of_a, of_b);
        if (area > 1e-6 * std::min(of_a.area, of_b.area))
            assembly.touching.push_back({a.part->id, b.part->id, area});
    }
}

} // namespace cad
