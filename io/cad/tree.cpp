// SPDX-License-Identifier: MIT
#include "tree.hpp"

#include "bodies.hpp"
#include "mesh.hpp"
#include "surface.hpp"

#include <BRepBndLib.hxx>
#include <Bnd_Box.hxx>
#include <Quantity_Color.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_ChildIterator.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Reference.hxx>
#include <TDataStd_Name.hxx>
#include <TDataStd_TreeNode.hxx>
#include <XCAFDoc.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <algorithm>
#include <cmath>
#include <set>

namespace cad
{

namespace
{

constexpr std::size_t most_parts = 1000000; // a file of a few uses of uses may stand for any number
constexpr int deepest = 256;

class Tree
{
  public:
    Tree(const Options &how, const Document &from, Assembly &into, Progress &shown)
        : options(how), document(from), assembly(into), progress(shown),
          colors(XCAFDoc_DocumentTool::ColorTool(from.xcaf->Main())),
          materials(XCAFDoc_DocumentTool::MaterialTool(from.xcaf->Main()))
    {
    }

    void build()
    {
        TDF_LabelSequence roots;
        XCAFDoc_DocumentTool::ShapeTool(document.xcaf->Main())->GetFreeShapes(roots);
        std::set<std::string> ids;
        for (const TDF_Label &root : roots)
            if (auto part = part_of(root, TDF_Label(), "", ids, 0))
                assembly.parts.push_back(std::move(*part));
        if (assembly.shapes.empty())
            throw Refused{options.input + ": no body and no face in it"};
    }

  private:
    struct Use { // a shape, placed in the frame of its product
        int shape;
        gp_Trsf place;
        std::string name;
        std::optional<Color> color;
    };

    const Options &options;
    const Document &document;
    Assembly &assembly;
    Progress &progress;
    Handle(XCAFDoc_ColorTool) colors;
    Handle(XCAFDoc_MaterialTool) materials;
    std::map<std::string, std::vector<Use>> products; // by label
    struct Meshed {
        int shape;
        gp_Trsf place; // of the shape as it is where the body has no location
    };
    ByShape<Meshed> meshed;
    std::size_t parts = 0;

    static Named named(const std::map<std::string, Named> &names, const TDF_Label &label)
    {
        const auto found = names.find(entry_of(label));
        return found == names.end() ? Named() : found->second;
    }

    static std::string label_name(const TDF_Label &label)
    {
        Handle(TDataStd_Name) name;
        return label.FindAttribute(TDataStd_Name::GetID(), name)
                   ? text_of(TCollection_AsciiString(name->Get()).ToCString())
                   : "";
    }

    std::optional<Color> color_of(const TDF_Label &label) const
    {
        for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
            Quantity_Color color;
            if (colors->GetColor(label, type, color)) {
                Color rgb;
                color.Values(rgb[0], rgb[1], rgb[2], Quantity_TOC_sRGB);
                for (double &value : rgb)
                    value = std::round(value * 1e6) / 1e6; // stored as floats
                return rgb;
            }
        }
        return {};
    }

    std::string material_of(const TDF_Label &label) const
    {
        Handle(TDataStd_TreeNode) node;
        if (!label.FindAttribute(XCAFDoc::MaterialRefGUID(), node) || !node->HasFather())
            return "";
        Handle(TCollection_HAsciiString) name, description, density_name, density_type;
        double density;
        if (!materials->GetMaterial(node->Father()->Label(), name, description, density,
                                    density_name, density_type) ||
            name.IsNull())
            return "";
        return text_of(name->ToCString());
    }

    // A count of uses tells nothing of which is which: one more before it, and all others are told
    // anew.
    static bool counted(const std::string &id)
    {
        const std::size_t start = id.compare(0, 4, "NAUO") == 0 ? 4 : 0;
        return id.find_first_not_of("0123456789", start) == std::string::npos;
    }

    static std::string unique(const std::string &wanted, std::set<std::string> &taken)
    {
        std::string id = wanted;
        for (int i = 2; !taken.insert(id).second; ++i)
            id = wanted + "." + std::to_string(i);
        return id;
    }

    std::optional<Part> part_of(const TDF_Label &label, const TDF_Label &use,
                                const std::string &above, std::set<std::string> &siblings,
                                int depth)
    {
        if (++parts > most_parts)
            throw Refused{options.input + ": more than 1,000,000 parts"};
        if (depth > deepest)
            throw Refused{options.input + ": assemblies nested more than 256 deep"};
        const Named product = named(document.products, label);
        const Named instance = use.IsNull() ? Named() : named(document.uses, use);
        Part part;
        part.name = !instance.name.empty() && !counted(instance.name) &&
                            instance.name != "Next assembly relationship"
                        ? instance.name
                    : product.name.empty() ? label_name(label)
                                           : product.name;
        std::string id = product.id.empty() ? part.name : product.id;
        if (!instance.id.empty() && !counted(instance.id) && instance.id != id)
            id += ":" + instance.id;
        std::replace(id.begin(), id.end(), '/', '_');
        part.id = above + unique(id.empty() ? "part" : id, siblings);
        part.material = material_of(label);
        part.color = use.IsNull() ? std::nullopt : color_of(use);
        if (!part.color)
            part.color = color_of(label);
        if (!use.IsNull())
            part.place = XCAFDoc_ShapeTool::GetLocation(use).Transformation();
        std::set<std::string> ids;
        if (XCAFDoc_ShapeTool::IsAssembly(label)) {
            TDF_LabelSequence components;
            XCAFDoc_ShapeTool::GetComponents(label, components);
            for (const TDF_Label &component : components) {
                TDF_Label referred;
                if (!XCAFDoc_ShapeTool::GetReferredShape(component, referred))
                    continue;
                if (auto child = part_of(referred, component, part.id + "/", ids, depth + 1))
                    part.parts.push_back(std::move(*child));
            }
            return part.parts.empty() ? std::nullopt : std::optional<Part>(std::move(part));
        }
        return with_bodies(label, std::move(part), ids);
    }

    std::optional<Part> with_bodies(const TDF_Label &label, Part part, std::set<std::string> &ids)
    {
        const std::vector<Use> &uses = uses_of(label, part);
        if (uses.empty())
            return {};
        if (uses.size() == 1) {
            part.shape = uses[0].shape;
            part.place.Multiply(uses[0].place);
            if (!part.color)
                part.color = uses[0].color;
            return part;
        }
        int k = 0;
        for (const Use &use : uses) {
            ++parts;
            Part body;
            const std::string number = std::to_string(++k);
            std::string word = use.name.empty() ? number : use.name;
            std::replace(word.begin(), word.end(), '/', '_');
            body.id = part.id + "/" + unique(word, ids);
            body.name = use.name.empty() ? part.name + " " + number : use.name;
            body.material = part.material;
            body.color = use.color ? use.color : part.color;
            body.place = use.place;
            body.shape = use.shape;
            part.parts.push_back(body);
        }
        return part;
    }

    const std::vector<Use> &uses_of(const TDF_Label &label, const Part &part)
    {
        const std::string entry = entry_of(label);
        const auto known = products.find(entry);
        if (known != products.end())
            return known->second;
        ByShape<Color> look;
        for (TDF_ChildIterator it(label); it.More(); it.Next()) {
            const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(it.Value());
            const std::optional<Color> color = color_of(it.Value());
            if (!shape.IsNull() && color)
                look[identity(shape)] = *color;
        }
        std::vector<Use> uses;
        const std::vector<Body> bodies = bodies_of(XCAFDoc_ShapeTool::GetShape(label), document);
        if (bodies.empty())
            assembly.warn(part.id, "has no body and no face: left out");
        for (const Body &body : bodies)
            uses.push_back(use_of(body, part, look));
        return products[entry] = std::move(uses);
    }

    Use use_of(const Body &body, const Part &part, const ByShape<Color> &look)
    {
        Use use{-1, gp_Trsf(), body.name, std::nullopt};
        if (const auto color = look.find(identity(body.shape)); color != look.end())
            use.color = color->second;
        const auto found = meshed.find(identity(body.shape));
        if (found != meshed.end()) {
            use.shape = found->second.shape;
            use.place = body.shape.Location().Transformation() * found->second.place;
            return use;
        }
        progress.step("meshing bodies", assembly.shapes.size());
        Shape shape = shape_of(body, part);
        for (Face &face : shape.faces) {
            if (const auto name = document.names.find(body.source_of(face.brep));
                name != document.names.end())
                face.name = name->second;
            if (const auto color = look.find(body.source_of(face.brep)); color != look.end())
                face.color = color->second;
        }
        if (!use.color && !part.color)
            use.color = common_color(shape);
        for (std::size_t i = 0; i < assembly.shapes.size() && use.shape < 0; ++i)
            if (same_look(assembly.shapes[i], shape) &&
                copy_of(assembly.shapes[i], shape, use.place))
                use.shape = static_cast<int>(i);
        if (use.shape < 0) {
            use.place = gp_Trsf();
            use.shape = static_cast<int>(assembly.shapes.size());
            assembly.shapes.push_back(std::move(shape));
        }
        meshed[identity(body.shape)] = {
            use.shape, body.shape.Location().Transformation().Inverted() * use.place};
        return use;
    }

    static std::optional<Color> common_color(const Shape &shape)
    {
        std::optional<Color> color = shape.faces.empty() ? std::nullopt : shape.faces[0].color;
        for (const Face &face : shape.faces)
            if (face.color != color)
                return {};
        return color;
    }

    // Faces that have names or colours of their own are theirs: such a shape is no copy of another.
    static bool same_look(const Shape &a, const Shape &b)
    {
        const auto plain = [](const Shape &shape) {
            return std::all_of(shape.faces.begin(), shape.faces.end(), [&](const Face &face) {
                return face.name.empty() && face.color == shape.faces[0].color;
            });
        };
        return a.form == b.form && plain(a) && plain(b) && common_color(a) == common_color(b);
    }

    Shape shape_of(const Body &body, const Part &part)
    {
        Shape shape;
        shape.brep = body.shape;
        shape.name = body.name.empty() ? part.name : body.name;
        Bnd_Box box;
        BRepBndLib::AddOptimal(body.shape, box, Standard_False, Standard_False);
        const double size = box.IsVoid() ? 1 : std::sqrt(box.SquareExtent());
        if (!(size > 0 && size < 1e9))
            throw Refused{options.input + ": " + part.id + " is " + std::to_string(size) +
                          " mm large"};
        shape.chord = options.chord > 0 ? options.chord : Options::chord_of_size * size;
        const MeshReport report = make_mesh(shape, options.angle * M_PI / 180);
        measure(shape);
        sign(shape);
        tell(body, part, report, shape);
        return shape;
    }

    void tell(const Body &body, const Part &part, const MeshReport &report, const Shape &shape)
    {
        const std::string entity = document.entity_of(body.shape);
        const std::string at = (entity.empty() ? "" : entity + ": ");
        if (const std::string faults = faults_of(body.shape, document); !faults.empty())
            assembly.warn(part.id, at + "OpenCASCADE finds " + faults);
        if (report.empty_faces > 0)
            assembly.warn(part.id,
                          at + std::to_string(report.empty_faces) + " faces could not be meshed");
        if (!shape.closed)
            assembly.warn(part.id, at + "is no closed body: " + std::to_string(report.open_edges) +
                                       " edges of its mesh have not two triangles");
        if (body.sewn)
            assembly.warn(
                part.id, at + "its faces shared no edges in the file and were sewn within 1e-5 mm");
        if (report.turned)
            assembly.warn(part.id, at + "was inside out: turned");
        if (report.off > exactness) {
            char text[120];
            std::snprintf(text, sizeof text,
                          "vertices lie up to %.2g mm off the true surfaces that meet there",
                          report.off);
            assembly.warn(part.id, at + text);
        }
    }
};

} // namespace

void build_tree(const Options &options, const Document &document, Assembly &assembly,
                Progress &progress)
{
    Tree(options, document, assembly, progress).build();
}

} // namespace cad
