// SPDX-License-Identifier: MIT
//
// make_cad_files FOLDER [PARTS]: STEP and IGES files of known bodies, for the tests of raymap-step
// and of what reads what it writes. With PARTS, many.step alone, an assembly of so many parts.
#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRep_Builder.hxx>
#include <GCE2d_MakeSegment.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <Geom2d_Ellipse.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Parabola.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Controller.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Parab.hxx>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace
{

const gp_Dir up(0, 0, 1);

class File
{
  public:
    File()
    {
        XCAFApp_Application::GetApplication()->NewDocument("BinXCAF", document);
        shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
        colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
        materials = XCAFDoc_DocumentTool::MaterialTool(document->Main());
    }
    TDF_Label product(const TopoDS_Shape &shape, const char *name)
    {
        const TDF_Label label = shapes->AddShape(shape, Standard_False);
        TDataStd_Name::Set(label, name);
        return label;
    }
    TDF_Label assembly(const char *name)
    {
        const TDF_Label label = shapes->NewShape();
        TDataStd_Name::Set(label, name);
        return label;
    }
    TDF_Label use(const TDF_Label &in, const TDF_Label &of, const char *name, const gp_Trsf &place)
    {
        const TDF_Label label = shapes->AddComponent(in, of, TopLoc_Location(place));
        TDataStd_Name::Set(label, name);
        return label;
    }
    void color(const TDF_Label &label, double r, double g, double b)
    {
        colors->SetColor(label, Quantity_Color(r, g, b, Quantity_TOC_sRGB), XCAFDoc_ColorSurf);
    }
    void color(const TDF_Label &label, const TopoDS_Shape &face, double r, double g, double b)
    {
        color(shapes->AddSubShape(label, face), r, g, b);
    }
    void material(const TDF_Label &label, const char *name)
    {
        const auto text = [](const char *it) { return new TCollection_HAsciiString(it); };
        materials->SetMaterial(label, text(name), text(""), 2.51, text("g/cm3"),
                               text("POSITIVE_RATIO_MEASURE"));
    }
    void step(const std::string &path, const char *schema = "AP214IS", const char *unit = "MM")
    {
        shapes->UpdateAssemblies();
        Interface_Static::SetCVal("write.step.schema", schema);
        Interface_Static::SetCVal("write.step.unit", unit);
        STEPCAFControl_Writer writer;
        if (!writer.Transfer(document, STEPControl_AsIs) ||
            writer.Write(path.c_str()) != IFSelect_RetDone)
            fail(path);
    }
    void iges(const std::string &path, bool brep)
    {
        Interface_Static::SetIVal("write.iges.brep.mode", brep);
        IGESCAFControl_Writer writer;
        if (!writer.Transfer(document) || !writer.Write(path.c_str()))
            fail(path);
    }

  private:
    Handle(TDocStd_Document) document;
    Handle(XCAFDoc_ShapeTool) shapes;
    Handle(XCAFDoc_ColorTool) colors;
    Handle(XCAFDoc_MaterialTool) materials;

    [[noreturn]] static void fail(const std::string &path)
    {
        std::fprintf(stderr, "%s: not written\n", path.c_str());
        std::exit(1);
    }
};

gp_Trsf at(double x, double y, double z, double turn = 0, const gp_Dir &about = up)
{
    gp_Trsf rotation, move;
    rotation.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), about), turn);
    move.SetTranslation(gp_Vec(x, y, z));
    return move * rotation;
}

TopoDS_Shape moved(const TopoDS_Shape &shape, const gp_Trsf &place)
{
    return BRepBuilderAPI_Transform(shape, place, Standard_True).Shape();
}

TopoDS_Shape cylinder(double radius, double from, double to)
{
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, from), up), radius, to - from).Shape();
}

TopoDS_Shape sphere(double radius, double z)
{
    return BRepPrimAPI_MakeSphere(gp_Ax2(gp_Pnt(0, 0, z), up), radius).Shape();
}

// Convex in front at z = 0, flat behind.
TopoDS_Shape plano_convex(double radius, double aperture, double thickness)
{
    return BRepAlgoAPI_Common(sphere(radius, radius), cylinder(aperture, -1, thickness)).Shape();
}

// Vertices at z = 0 and at the thickness.
TopoDS_Shape biconvex(double front, double back, double aperture, double thickness)
{
    const TopoDS_Shape both =
        BRepAlgoAPI_Common(sphere(front, front), sphere(back, thickness - back)).Shape();
    return BRepAlgoAPI_Common(both, cylinder(aperture, -1, thickness + 1)).Shape();
}

// Cemented to the back of the biconvex: concave in front, flat behind.
TopoDS_Shape flint(double back, double aperture, double from, double to)
{
    return BRepAlgoAPI_Cut(cylinder(aperture, from - 10, to), sphere(back, from - back)).Shape();
}

TopoDS_Shape compound(const std::vector<TopoDS_Shape> &parts)
{
    TopoDS_Compound out;
    BRep_Builder builder;
    builder.MakeCompound(out);
    for (const TopoDS_Shape &part : parts)
        builder.Add(out, part);
    return out;
}

// The bottle's thread of OpenCASCADE's tutorial: two helical wires on cylinders, a ruled skin
// between them.
TopoDS_Shape thread(double radius, double height)
{
    const gp_Ax2 axes(gp_Pnt(0, 0, 0), up);
    const Handle(Geom_CylindricalSurface) inner = new Geom_CylindricalSurface(axes, radius * 0.99);
    const Handle(Geom_CylindricalSurface) outer = new Geom_CylindricalSurface(axes, radius * 1.05);
    const gp_Pnt2d middle(2 * M_PI, height / 2);
    const gp_Ax2d along(middle, gp_Dir2d(2 * M_PI, height / 4));
    const double length = 2 * M_PI, width = height / 10;
    const Handle(Geom2d_Ellipse) first = new Geom2d_Ellipse(along, length, width);
    const Handle(Geom2d_Ellipse) second = new Geom2d_Ellipse(along, length, width / 4);
    const Handle(Geom2d_TrimmedCurve) arcs[2] = {new Geom2d_TrimmedCurve(first, 0, M_PI),
                                                 new Geom2d_TrimmedCurve(second, 0, M_PI)};
    const Handle(Geom2d_TrimmedCurve) segment =
        GCE2d_MakeSegment(first->Value(0), first->Value(M_PI)).Value();
    BRepOffsetAPI_ThruSections skin(Standard_True);
    const Handle(Geom_CylindricalSurface) surfaces[2] = {inner, outer};
    for (int k = 0; k < 2; ++k) {
        const TopoDS_Wire wire =
            BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(arcs[k], surfaces[k]),
                                    BRepBuilderAPI_MakeEdge(segment, surfaces[k]));
        BRepLib::BuildCurves3d(wire);
        skin.AddWire(wire);
    }
    skin.CheckCompatibility(Standard_False);
    return skin.Shape();
}

// A paraboloid of 2 mm sheet, z = x^2 / (4 f).
TopoDS_Shape reflector(double focus, double height)
{
    const auto rim = [](double f, double z) { return 2 * std::sqrt(f * z); };
    const auto edge = [&](double f, double z) {
        const gp_Parab curve(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 1, 0), up), f);
        const double end = rim(f, height - z);
        return BRepBuilderAPI_MakeEdge(curve, 0, end).Edge();
    };
    const gp_Pnt a(0, 0, 0), b(0, 0, -2), c(rim(focus, height), 0, height),
        d(rim(focus, height + 2), 0, height);
    BRepBuilderAPI_MakeWire wire(edge(focus, 0), BRepBuilderAPI_MakeEdge(c, d), edge(focus, -2),
                                 BRepBuilderAPI_MakeEdge(b, a));
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(wire.Wire()), gp_Ax1(a, up)).Shape();
}

void write_one(const std::string &path, const TopoDS_Shape &shape, const char *name)
{
    File file;
    file.product(shape, name);
    file.step(path);
}

void write_primitives(const std::string &folder)
{
    write_one(folder + "box.step", BRepPrimAPI_MakeBox(10, 20, 30).Shape(), "box");
    write_one(folder + "cylinder.step", cylinder(7, -5, 12), "cylinder");
    write_one(folder + "sphere.step", sphere(9, 4), "sphere");
    write_one(folder + "cone.step", BRepPrimAPI_MakeCone(8, 3, 10).Shape(), "cone");
    write_one(folder + "tip.step",
              moved(BRepPrimAPI_MakeCone(8, 0, 10).Shape(), at(3, 2, 1, 0.7, gp_Dir(1, 1, 0))),
              "tip");
    write_one(folder + "torus.step", BRepPrimAPI_MakeTorus(20, 5).Shape(), "torus");
    write_one(folder + "plano-convex.step", plano_convex(51.68, 12.7, 4), "plano-convex");
    write_one(folder + "biconvex.step", biconvex(50, 80, 12.7, 6), "biconvex");
    write_one(folder + "thread.step", thread(5, 20), "thread");
    const TopoDS_Shape ring = BRepPrimAPI_MakeTorus(20, 5).Shape();
    const TopoDS_Shape cone =
        moved(BRepPrimAPI_MakeCone(8, 3, 10).Shape(), at(1, 2, 3, 0.3, gp_Dir(1, 2, 3)));
    // The same bodies with every surface a rational B-spline.
    for (const auto &[shape, name] : {std::pair(biconvex(50, 80, 12.7, 6), "spline-lens"),
                                      {ring, "spline-torus"},
                                      {cone, "spline-cone"}})
        write_one(folder + name + ".step",
                  BRepBuilderAPI_NurbsConvert(shape, Standard_True).Shape(), name);
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(10, 20, 30).Shape();
    write_one(folder + "sheet.step", TopExp_Explorer(box, TopAbs_FACE).Current(), "sheet");
    TopoDS_Compound loose; // six faces that share no edges
    BRep_Builder builder;
    builder.MakeCompound(loose);
    for (TopExp_Explorer it(box, TopAbs_FACE); it.More(); it.Next())
        builder.Add(loose, BRepBuilderAPI_Copy(it.Current()).Shape());
    write_one(folder + "loose.step", loose, "loose");
    write_one(folder + "inside-out.step",
              BRepBuilderAPI_MakeSolid(
                  TopoDS::Shell(TopExp_Explorer(box, TopAbs_SHELL).Current().Reversed()))
                  .Shape(),
              "inside-out");
}

void write_copies(const std::string &folder)
{
    // Its own mirror image in no way: a hole and a notch.
    const TopoDS_Shape hole = moved(cylinder(3, -1, 50), at(4, 6, 0));
    const TopoDS_Shape notch = BRepPrimAPI_MakeBox(gp_Pnt(-1, 15, 24), 4, 9, 9).Shape();
    const TopoDS_Shape wedge =
        BRepAlgoAPI_Cut(BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), hole), notch)
            .Shape();
    gp_Trsf mirror;
    mirror.SetMirror(gp_Ax2(gp_Pnt(-20, 0, 0), gp_Dir(1, 0, 0)));
    const TopoDS_Shape lens = biconvex(50, 80, 12.7, 6);
    std::vector<TopoDS_Shape> all = {wedge,
                                     moved(wedge, at(40, 5, 0, 0.7, gp_Dir(1, 2, 3))),
                                     moved(wedge, mirror),
                                     lens,
                                     moved(lens, at(0, 60, 7, 1.1, gp_Dir(3, 1, 0))),
                                     BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 50), 10, 20, 30.001).Shape()};
    write_one(folder + "copies.step", compound(all), "copies");
    all.erase(all.begin());
    write_one(folder + "copies-revised.step", compound(all), "copies"); // all are counted anew
}

// A luminaire in a nested assembly: two of its screws are one product, its lens lies on the
// housing's rim.
void write_luminaire(const std::string &folder, const char *name, bool revised, const char *schema,
                     const char *unit)
{
    File file;
    const TDF_Label root = file.assembly("luminaire"), optics = file.assembly("optics");
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(gp_Pnt(-40, -40, -10), gp_Pnt(40, 40, 30)).Shape();
    const TopoDS_Shape body = BRepAlgoAPI_Cut(box, cylinder(34, -5, 31)).Shape();
    const TDF_Label housing = file.product(body, "housing");
    file.color(housing, 0.2, 0.2, 0.25);
    const TDF_Label mirror = file.product(reflector(8, 24), "reflector");
    file.color(mirror, 0.9, 0.9, 0.95);
    const TopoDS_Shape glass = plano_convex(90, 40, 8);
    const TDF_Label lens = file.product(glass, "lens");
    file.color(lens, 0.6, 0.8, 1);
    int k = 0;
    for (TopExp_Explorer it(glass, TopAbs_FACE); it.More(); it.Next(), ++k)
        if (k == 0)
            file.color(lens, it.Current(), 1, 0.5, 0);
    file.material(lens, "N-BK7");
    const TDF_Label bolt =
        file.product(BRepAlgoAPI_Fuse(cylinder(2, 0, 10), cylinder(4, 10, 12)).Shape(), "bolt");
    file.use(root, housing, "housing", gp_Trsf());
    file.use(root, optics, "optics", at(0, 0, 1));
    file.use(optics, mirror, "reflector", at(0, 0, 1));
    file.use(optics, lens, revised ? "front lens" : "lens", at(0, 0, 37, M_PI, gp_Dir(1, 0, 0)));
    file.use(root, bolt, "bolt left", at(-60, 0, 0));
    const TDF_Label right =
        file.use(root, bolt, "bolt right", revised ? at(60, 5, 0) : at(60, 0, 0, 1.2));
    file.color(right, 1, 0, 0);
    file.step(folder + name, schema, unit);
}

void write_doublet(const std::string &folder)
{
    File file;
    const TDF_Label root = file.assembly("doublet");
    file.use(root, file.product(biconvex(50, 40, 12, 8), "crown"), "crown", gp_Trsf());
    file.use(root, file.product(flint(40, 12, 8, 12), "flint"), "flint", gp_Trsf());
    file.step(folder + "doublet.step");
}

void write_iges(const std::string &folder)
{
    for (const bool brep : {true, false}) {
        File file;
        const TDF_Label lens = file.product(biconvex(50, 80, 12.7, 6), "biconvex");
        file.color(lens, 1, 0, 0);
        file.iges(folder + (brep ? "lens-brep.igs" : "lens-faces.igs"), brep);
    }
}

// Plates with holes, lenses, housings and screws: every fifth part is a body of its own, the others
// are uses of those.
void write_many(const std::string &path, int count)
{
    File file;
    const TDF_Label root = file.assembly("machine");
    const int products = std::max(1, count / 5);
    std::vector<TDF_Label> made;
    for (int i = 0; i < products; ++i) {
        TopoDS_Shape shape;
        const double size = 10 + 0.1 * i;
        if (i % 4 == 0) {
            shape = BRepPrimAPI_MakeBox(3 * size, 2 * size, 4).Shape();
            for (int k = 0; k < 6; ++k)
                shape = BRepAlgoAPI_Cut(shape, moved(cylinder(2, -1, 5), at(5 + 4.5 * k, 5 + k, 0)))
                            .Shape();
        } else if (i % 4 == 1) {
            shape = biconvex(5 * size, 7 * size, size, 0.6 * size);
        } else if (i % 4 == 2) {
            shape = BRepAlgoAPI_Cut(cylinder(size, 0, 20), cylinder(0.8 * size, 2, 21)).Shape();
        } else {
            shape = BRepAlgoAPI_Fuse(cylinder(0.3 * size, 0, 12), thread(0.3 * size, 10)).Shape();
        }
        const std::string name = "part " + std::to_string(i);
        made.push_back(file.product(shape, name.c_str()));
        file.color(made.back(), 0.1 + 0.8 * i / products, 0.5, 0.5);
    }
    TDF_Label group;
    for (int i = 0; i < count; ++i) {
        if (i % 25 == 0) {
            const std::string name = "group " + std::to_string(i / 25);
            group = file.assembly(name.c_str());
            file.use(root, group, name.c_str(), at(0, 60.0 * (i / 25), 0));
        }
        const std::string name = "use " + std::to_string(i);
        file.use(group, made[static_cast<std::size_t>(i % products)], name.c_str(),
                 at(70.0 * (i % 25), 0, 0, 0.1 * i));
    }
    file.step(path);
}

} // namespace

int main(int count, char **words)
{
    if (count < 2) {
        std::fputs("usage: make_cad_files FOLDER [PARTS]\n", stderr);
        return 2;
    }
    Message::DefaultMessenger()->ChangePrinters().Clear();
    STEPControl_Controller::Init();
    IGESControl_Controller::Init();
    const std::string folder = std::string(words[1]) + "/";
    if (count > 2) {
        write_many(folder + "many.step", std::atoi(words[2]));
        return 0;
    }
    write_primitives(folder);
    write_copies(folder);
    write_luminaire(folder, "luminaire.step", false, "AP214IS", "MM");
    write_luminaire(folder, "luminaire-revised.step", true, "AP214IS", "MM");
    write_luminaire(folder, "luminaire-203.step", false, "AP203", "MM");
    write_luminaire(folder, "luminaire-242.step", false, "AP242DIS", "MM");
    write_luminaire(folder, "luminaire-inch.step", false, "AP214IS", "INCH");
    write_doublet(folder);
    write_iges(folder);
    return 0;
}
