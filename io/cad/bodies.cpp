// SPDX-License-Identifier: MIT
#include "bodies.hpp"

#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepCheck_ListOfStatus.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <GProp_PrincipalProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>

#include <algorithm>

namespace cad
{

static std::string name_in(const Document &document, const TopoDS_Shape &shape)
{
    const auto found = document.names.find(identity(shape));
    return found == document.names.end() ? "" : found->second;
}

static TopoDS_Shape solid_of(const TopoDS_Shape &shell)
{
    if (shell.ShapeType() != TopAbs_SHELL || !BRep_Tool::IsClosed(shell))
        return shell;
    BRepBuilderAPI_MakeSolid solid(TopoDS::Shell(shell));
    return solid.Shape();
}

const void *Body::source_of(const TopoDS_Shape &face) const
{
    const auto found = sources.find(identity(face));
    return found == sources.end() ? identity(face) : found->second;
}

static std::vector<Body> sewn_of(const TopoDS_Shape &faces, const std::string &name)
{
    BRepBuilderAPI_Sewing sewing(1e-5);
    sewing.Add(faces);
    sewing.Perform();
    ByShape<const void *> sources;
    for (TopExp_Explorer it(faces, TopAbs_FACE); it.More(); it.Next())
        if (sewing.IsModifiedSubShape(it.Current()))
            sources[identity(sewing.ModifiedSubShape(it.Current()))] = identity(it.Current());
    std::vector<Body> bodies;
    if (sewing.SewedShape().IsNull())
        return bodies;
    for (TopExp_Explorer it(sewing.SewedShape(), TopAbs_SHELL); it.More(); it.Next())
        bodies.push_back({solid_of(it.Current()), name, true, sources});
    for (TopExp_Explorer it(sewing.SewedShape(), TopAbs_FACE, TopAbs_SHELL); it.More(); it.Next())
        bodies.push_back({it.Current(), name, false, sources});
    return bodies;
}

static bool shells_closed(const TopoDS_Shape &solid)
{
    for (TopExp_Explorer it(solid, TopAbs_SHELL); it.More(); it.Next())
        if (!BRep_Tool::IsClosed(it.Current()))
            return false;
    return true;
}

static bool all_closed(const std::vector<Body> &bodies)
{
    return !bodies.empty() && std::all_of(bodies.begin(), bodies.end(), [](const Body &body) {
        return body.shape.ShapeType() == TopAbs_SOLID;
    });
}

std::vector<Body> bodies_of(const TopoDS_Shape &product, const Document &document)
{
    std::vector<Body> bodies, loose;
    for (TopExp_Explorer it(product, TopAbs_SOLID); it.More(); it.Next()) {
        Body body{it.Current(), name_in(document, it.Current()), false, {}};
        std::vector<Body> sewn;
        if (!shells_closed(body.shape))
            sewn = sewn_of(body.shape, body.name);
        bodies.push_back(sewn.size() == 1 && all_closed(sewn) ? sewn[0] : body);
    }
    TopoDS_Compound sheets;
    BRep_Builder builder;
    builder.MakeCompound(sheets);
    for (const TopAbs_ShapeEnum type : {TopAbs_SHELL, TopAbs_FACE})
        for (TopExp_Explorer it(product, type, type == TopAbs_SHELL ? TopAbs_SOLID : TopAbs_SHELL);
             it.More(); it.Next()) {
            const Body body{solid_of(it.Current()), name_in(document, it.Current()), false, {}};
            if (body.shape.ShapeType() == TopAbs_SOLID) {
                bodies.push_back(body);
                continue;
            }
            builder.Add(sheets, it.Current());
            loose.push_back(body);
        }
    if (loose.empty())
        return bodies;
    // IGES has faces alone, which are a body's; in STEP sheets are meant, unless they close.
    const std::vector<Body> sewn = sewn_of(sheets, "");
    const std::vector<Body> &kept = !document.step || all_closed(sewn) ? sewn : loose;
    bodies.insert(bodies.end(), kept.begin(), kept.end());
    return bodies;
}

void measure(Shape &shape)
{
    GProp_GProps whole, skin;
    shape.area = 0;
    for (Face &face : shape.faces) {
        GProp_GProps props;
        BRepGProp::SurfaceProperties(face.brep, props, 1e-8);
        face.area = props.Mass();
        face.centroid = props.CentreOfMass().XYZ();
        shape.area += face.area;
        skin.Add(props);
    }
    if (shape.closed)
        BRepGProp::VolumeProperties(shape.brep, whole, 1e-8);
    shape.volume = shape.closed ? std::abs(whole.Mass()) : 0;
    const GProp_GProps &props = shape.closed ? whole : skin;
    shape.centroid = props.CentreOfMass().XYZ();
    const GProp_PrincipalProps principal = props.PrincipalProperties();
    principal.Moments(shape.moments[0], shape.moments[1], shape.moments[2]);
    for (double &moment : shape.moments)
        moment = std::abs(moment);
    std::sort(shape.moments.begin(), shape.moments.end());
    shape.lower = gp_XYZ(1e300, 1e300, 1e300);
    shape.upper = shape.lower * -1;
    for (const gp_XYZ &at : shape.mesh.vertices)
        for (int i = 1; i <= 3; ++i) {
            shape.lower.SetCoord(i, std::min(shape.lower.Coord(i), at.Coord(i)));
            shape.upper.SetCoord(i, std::max(shape.upper.Coord(i), at.Coord(i)));
        }
}

static const char *fault_name(BRepCheck_Status status)
{
    switch (status) {
    case BRepCheck_SelfIntersectingWire:
        return "a self-intersecting boundary";
    case BRepCheck_IntersectingWires:
        return "boundaries that cross each other";
    case BRepCheck_UnorientableShape:
    case BRepCheck_BadOrientation:
    case BRepCheck_BadOrientationOfSubshape:
        return "an orientation that does not fit";
    case BRepCheck_NotClosed:
        return "a boundary that is not closed";
    case BRepCheck_FreeEdge:
        return "an edge of one face alone";
    case BRepCheck_InvalidMultiConnexity:
        return "an edge of more than two faces";
    case BRepCheck_InvalidCurveOnSurface:
    case BRepCheck_InvalidCurveOnClosedSurface:
    case BRepCheck_InvalidSameParameterFlag:
    case BRepCheck_InvalidSameRangeFlag:
        return "an edge that lies off its surface";
    default:
        return "a fault in its topology";
    }
}

std::string faults_of(const TopoDS_Shape &shape, const Document &document)
{
    const BRepCheck_Analyzer check(shape);
    if (check.IsValid())
        return "";
    std::string text;
    int told = 0;
    TopTools_IndexedMapOfShape parts;
    TopExp::MapShapes(shape, parts);
    for (Standard_Integer i = 1; i <= parts.Extent() && told < 3; ++i) {
        const Handle(BRepCheck_Result) &result = check.Result(parts(i));
        if (result.IsNull())
            continue;
        for (const BRepCheck_Status status : result->Status()) {
            if (status == BRepCheck_NoError)
                continue;
            const std::string entity = document.entity_of(parts(i));
            text += (told++ > 0 ? "; " : "") + std::string(fault_name(status)) +
                    (entity.empty() ? "" : " (" + entity + ")");
            break;
        }
    }
    return text.empty() ? "a fault in its topology" : text;
}

} // namespace cad
