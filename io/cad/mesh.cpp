// SPDX-License-Identifier: MIT
#include "mesh.hpp"

#include "surface.hpp"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cad
{

// Nodes of faces that are one vertex of the mesh.
class Joined
{
  public:
    explicit Joined(std::size_t n) : parent(n)
    {
        std::iota(parent.begin(), parent.end(), 0U);
    }
    std::uint32_t find(std::uint32_t i)
    {
        while (parent[i] != i)
            i = parent[i] = parent[parent[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b)
    {
        a = find(a);
        b = find(b);
        parent[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent;
};

struct Pieces {
    std::vector<Handle(Poly_Triangulation)> triangulation; // of each face
    std::vector<TopLoc_Location> location;
    std::vector<std::uint32_t> first; // node of each face, and the end
};

static void join_chain(Joined &joined, const Handle(Poly_PolygonOnTriangulation) & chain,
                       std::uint32_t first, std::vector<std::uint32_t> &of_edge)
{
    if (chain.IsNull())
        return;
    const Standard_Integer n = chain->NbNodes();
    if (of_edge.empty())
        for (Standard_Integer i = 1; i <= n; ++i)
            of_edge.push_back(first + static_cast<std::uint32_t>(chain->Node(i) - 1));
    if (of_edge.size() == static_cast<std::size_t>(n))
        for (Standard_Integer i = 1; i <= n; ++i)
            joined.join(of_edge[static_cast<std::size_t>(i - 1)],
                        first + static_cast<std::uint32_t>(chain->Node(i) - 1));
}

// Along each edge all faces have the same nodes in the same order; a seam has two chains in one
// face, and the nodes of an edge without length are one.
static void join_edges(const Shape &shape, const Pieces &pieces, Joined &joined)
{
    TopTools_IndexedMapOfShape edges, corners;
    TopExp::MapShapes(shape.brep, TopAbs_EDGE, edges);
    TopExp::MapShapes(shape.brep, TopAbs_VERTEX, corners);
    std::vector<std::vector<std::uint32_t>> chains(static_cast<std::size_t>(edges.Extent()));
    std::vector<std::int64_t> corner(static_cast<std::size_t>(corners.Extent()), -1);
    for (std::size_t f = 0; f < shape.faces.size(); ++f) {
        if (pieces.triangulation[f].IsNull())
            continue;
        for (TopExp_Explorer it(shape.faces[f].brep, TopAbs_EDGE); it.More(); it.Next()) {
            const TopoDS_Edge edge = TopoDS::Edge(it.Current());
            const Handle(Poly_PolygonOnTriangulation) chain = BRep_Tool::PolygonOnTriangulation(
                edge, pieces.triangulation[f], pieces.location[f]);
            if (chain.IsNull())
                continue;
            const auto node = [&](Standard_Integer i) {
                return pieces.first[f] + static_cast<std::uint32_t>(chain->Node(i) - 1);
            };
            if (BRep_Tool::Degenerated(edge))
                for (Standard_Integer i = 2; i <= chain->NbNodes(); ++i)
                    joined.join(node(1), node(i));
            else
                join_chain(joined, chain, pieces.first[f],
                           chains[static_cast<std::size_t>(edges.FindIndex(edge) - 1)]);
            for (const bool last : {false, true}) {
                const TopoDS_Shape end =
                    last ? TopExp::LastVertex(edge) : TopExp::FirstVertex(edge);
                if (end.IsNull() || !corners.Contains(end))
                    continue;
                std::int64_t &at = corner[static_cast<std::size_t>(corners.FindIndex(end) - 1)];
                const std::uint32_t here = node(last ? chain->NbNodes() : 1);
                if (at < 0)
                    at = here;
                joined.join(static_cast<std::uint32_t>(at), here);
            }
        }
    }
}

static Pieces pieces_of(const Shape &shape, MeshReport &report)
{
    Pieces pieces;
    std::uint64_t n = 0;
    for (const Face &face : shape.faces) {
        TopLoc_Location location;
        pieces.triangulation.push_back(BRep_Tool::Triangulation(face.brep, location));
        pieces.location.push_back(location);
        pieces.first.push_back(static_cast<std::uint32_t>(n));
        if (pieces.triangulation.back().IsNull())
            ++report.empty_faces;
        else
            n += static_cast<std::uint64_t>(pieces.triangulation.back()->NbNodes());
        if (n > 0x7fffffffU)
            throw Refused{"a body has more than 2^31 vertices at this chord; give a larger --chord",
                          5};
    }
    pieces.first.push_back(static_cast<std::uint32_t>(n));
    return pieces;
}

static void collect(Shape &shape, const Pieces &pieces, Joined &joined)
{
    constexpr std::uint32_t unused = 0xffffffffU;
    std::vector<std::uint32_t> number(pieces.first.back(), unused);
    Mesh &mesh = shape.mesh;
    for (std::size_t f = 0; f < shape.faces.size(); ++f) {
        const Handle(Poly_Triangulation) &piece = pieces.triangulation[f];
        if (piece.IsNull())
            continue;
        const gp_Trsf place = pieces.location[f].Transformation();
        const bool flipped =
            (shape.faces[f].brep.Orientation() == TopAbs_REVERSED) != place.IsNegative();
        for (Standard_Integer t = 1; t <= piece->NbTriangles(); ++t) {
            Standard_Integer nodes[3];
            piece->Triangle(t).Get(nodes[0], nodes[1], nodes[2]);
            if (flipped)
                std::swap(nodes[1], nodes[2]);
            std::array<std::uint32_t, 3> corners;
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] =
                    joined.find(pieces.first[f] + static_cast<std::uint32_t>(nodes[k] - 1));
            if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
                continue;
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t &at = number[corners[k]];
                if (at == unused) {
                    at = static_cast<std::uint32_t>(mesh.vertices.size());
                    mesh.vertices.push_back(piece->Node(nodes[k]).Transformed(place).XYZ());
                }
                corners[k] = at;
            }
            mesh.triangles.push_back(corners);
            mesh.face.push_back(static_cast<std::uint32_t>(f));
        }
    }
}

// The least move that puts the point on all surfaces: Newton, with the least of least squares where
// they touch.
static double put_on(gp_XYZ &point, const std::vector<const Surface *> &surfaces, double reach)
{
    const gp_XYZ from = point;
    double worst = 0, before = 0;
    for (int round = 0; round < 12; ++round) {
        double m[3][3] = {}, right[3] = {};
        worst = 0;
        for (const Surface *surface : surfaces) {
            double value;
            gp_XYZ g;
            const bool smooth = distance(*surface, point, value, g);
            worst = std::max(worst, std::abs(value));
            if (!smooth && surface->kind == Kind::cone) { // its apex
                const gp_XYZ apex = surface->origin -
                                    surface->axis * (surface->radius1 / std::tan(surface->radius2));
                if ((apex - point).Modulus() <= reach)
                    point = apex;
                continue;
            }
            for (int i = 0; i < 3; ++i) {
                right[i] -= g.Coord(i + 1) * value;
                for (int j = 0; j < 3; ++j)
                    m[i][j] += g.Coord(i + 1) * g.Coord(j + 1);
            }
        }
        if (round == 0)
            before = worst;
        if (worst == 0)
            break;
        for (int i = 0; i < 3; ++i)
            m[i][i] += 1e-10;
        const gp_XYZ a(m[0][0], m[0][1], m[0][2]), b(m[1][0], m[1][1], m[1][2]),
            c(m[2][0], m[2][1], m[2][2]);
        const gp_XYZ r(right[0], right[1], right[2]);
        const double determinant = a * (b ^ c);
        if (!(std::abs(determinant) > 0))
            break;
        // Cramer's rule; the matrix is symmetric.
        const gp_XYZ move(r * (b ^ c) / determinant, a * (r ^ c) / determinant,
                          a * (b ^ r) / determinant);
        if (((point + move) - from).Modulus() > reach)
            break;
        point += move;
    }
    worst = 0;
    for (const Surface *surface : surfaces) {
        double value;
        gp_XYZ g;
        distance(*surface, point, value, g);
        worst = std::max(worst, std::abs(value));
    }
    if (worst > before)
        point = from;
    return std::min(worst, before);
}

static double put_on_surfaces(Shape &shape)
{
    Mesh &mesh = shape.mesh;
    std::vector<std::vector<std::uint32_t>> faces(mesh.vertices.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            if (std::find(faces[v].begin(), faces[v].end(), mesh.face[t]) == faces[v].end())
                faces[v].push_back(mesh.face[t]);
    double off = 0;
    for (std::size_t v = 0; v < faces.size(); ++v) {
        std::vector<const Surface *> surfaces;
        for (const std::uint32_t f : faces[v])
            if (shape.faces[f].surface.kind != Kind::none)
                surfaces.push_back(&shape.faces[f].surface);
        if (!surfaces.empty())
            off = std::max(off, put_on(mesh.vertices[v], surfaces, 0.1 * shape.chord));
    }
    return off;
}

// Edges that have not exactly one triangle on each side.
static std::size_t open_edges(const Mesh &mesh)
{
    std::vector<std::uint64_t> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const auto &corners : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t a = corners[k], b = corners[(k + 1) % 3];
            edges.push_back(a < b ? a << 33 | b << 1 : b << 33 | a << 1 | 1);
        }
    std::sort(edges.begin(), edges.end());
    std::size_t open = 0;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i;
        while (j < edges.size() && edges[j] >> 1 == edges[i] >> 1)
            ++j;
        open += !(j - i == 2 && edges[i] != edges[i + 1]);
        i = j;
    }
    return open;
}

static double volume_of(const Mesh &mesh)
{
    double volume = 0;
    for (const auto &corners : mesh.triangles) {
        const gp_XYZ &base = mesh.vertices.front();
        volume += (mesh.vertices[corners[0]] - base) *
                  ((mesh.vertices[corners[1]] - base) ^ (mesh.vertices[corners[2]] - base)) / 6;
    }
    return volume;
}

static void tell_sides(Shape &shape)
{
    std::vector<double> side(shape.faces.size());
    for (std::size_t t = 0; t < shape.mesh.triangles.size(); ++t) {
        const auto &[a, b, c] = shape.mesh.triangles[t];
        const std::vector<gp_XYZ> &at = shape.mesh.vertices;
        double value;
        gp_XYZ gradient;
        distance(shape.faces[shape.mesh.face[t]].surface, (at[a] + at[b] + at[c]) / 3, value,
                 gradient);
        side[shape.mesh.face[t]] += ((at[b] - at[a]) ^ (at[c] - at[a])) * gradient;
    }
    for (std::size_t f = 0; f < side.size(); ++f)
        shape.faces[f].hollow = side[f] < 0;
}

MeshReport make_mesh(Shape &shape, double angle)
{
    MeshReport report;
    IMeshTools_Parameters how;
    how.Deflection = shape.chord;
    how.Angle = angle;
    how.InParallel = Standard_True;
    BRepMesh_IncrementalMesh mesher(shape.brep, how);
    for (TopExp_Explorer it(shape.brep, TopAbs_FACE); it.More(); it.Next()) {
        Face face;
        face.brep = TopoDS::Face(it.Current());
        face.surface = surface_of(face.brep);
        shape.faces.push_back(face);
    }
    const Pieces pieces = pieces_of(shape, report);
    Joined joined(pieces.first.back());
    join_edges(shape, pieces, joined);
    collect(shape, pieces, joined);
    BRepTools::Clean(shape.brep);
    report.off = put_on_surfaces(shape);
    report.open_edges = open_edges(shape.mesh);
    shape.closed =
        report.open_edges == 0 && report.empty_faces == 0 && !shape.mesh.triangles.empty();
    if (shape.closed && volume_of(shape.mesh) < 0) {
        report.turned = true;
        for (auto &corners : shape.mesh.triangles)
            std::swap(corners[1], corners[2]);
    }
    tell_sides(shape);
    return report;
}

} // namespace cad
