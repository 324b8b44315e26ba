// SPDX-License-Identifier: MIT
#include "document.hpp"

#include <APIHeaderSection_MakeHeader.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPConstruct_ExternRefs.hxx>
#include <STEPConstruct_Tool.hxx>
#include <StepBasic_Product.hxx>
#include <StepBasic_ProductDefinition.hxx>
#include <StepBasic_ProductDefinitionFormation.hxx>
#include <StepData_StepModel.hxx>
#include <StepRepr_NextAssemblyUsageOccurrence.hxx>
#include <StepShape_SolidModel.hxx>
#include <StepShape_TopologicalRepresentationItem.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_Tool.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace cad
{

std::string entry_of(const TDF_Label &label)
{
    TCollection_AsciiString entry;
    TDF_Tool::Entry(label, entry);
    return entry.ToCString();
}

// Length of the UTF-8 character there, 0 where there is none.
static std::size_t utf8_length(const unsigned char *at)
{
    const std::size_t length = at[0] < 0x80       ? 1
                               : at[0] >> 5 == 6  ? 2
                               : at[0] >> 4 == 14 ? 3
                               : at[0] >> 3 == 30 ? 4
                                                  : 0;
    unsigned code = length < 2 ? at[0] : at[0] & (0x7fU >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((at[i] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (at[i] & 0x3f);
    }
    static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    return length == 0 || code < least[length] || code > 0x10ffff ||
                   (code >= 0xd800 && code < 0xe000)
               ? 0
               : length;
}

std::string text_of(const char *text)
{
    std::string out;
    for (auto *at = reinterpret_cast<const unsigned char *>(text ? text : ""); *at;) {
        const std::size_t length = utf8_length(at);
        if (length == 0) { // Latin-1, as old writers have it
            out += static_cast<char>(0xc0 | *at >> 6);
            out += static_cast<char>(0x80 | (*at & 0x3f));
        } else {
            out.append(reinterpret_cast<const char *>(at), length);
        }
        at += length == 0 ? 1 : length;
    }
    const std::size_t first = out.find_first_not_of(" \t\r\n");
    return first == std::string::npos
               ? ""
               : out.substr(first, out.find_last_not_of(" \t\r\n") - first + 1);
}

static std::string text_of(const Handle(TCollection_HAsciiString) & text)
{
    return text.IsNull() ? "" : text_of(text->ToCString());
}

std::string Document::entity_of(const TopoDS_Shape &shape) const
{
    const auto found = entities.find(identity(shape));
    return found == entities.end()
               ? ""
               : text_of(session->Model()->StringLabel(session->Model()->Value(found->second)));
}

// STEP begins with its number; IGES has the section's letter in column 73.
static bool is_step(const std::string &input)
{
    struct stat info;
    if (stat(input.c_str(), &info) != 0)
        throw Refused{input + ": " + std::strerror(errno)};
    if (!S_ISREG(info.st_mode))
        throw Refused{input + ": not a regular file"};
    std::ifstream file(input, std::ios::binary);
    std::string head(4096, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(file.gcount()));
    if (head.find("ISO-10303-21") != std::string::npos)
        return true;
    if (head.size() > 80 && head[72] == 'S' &&
        head.substr(73, 7).find_first_not_of("0123456789 ") == std::string::npos)
        return false;
    throw Refused{input + ": neither STEP (ISO-10303-21) nor IGES"};
}

static void tell_failures(const Options &options, const Interface_CheckIterator &found,
                          Assembly &assembly, const Handle(Interface_InterfaceModel) & model)
{
    int told = 0, more = 0;
    for (Interface_CheckIterator checks = found; checks.More(); checks.Next()) {
        const Handle(Interface_Check) &check = checks.Value();
        for (Standard_Integer i = 1; i <= check->NbFails(); ++i) {
            if (++told > 20) {
                ++more;
                continue;
            }
            const Handle(Standard_Transient) entity = model->Value(std::max(checks.Number(), 1));
            const std::string number =
                checks.Number() > 0 ? text_of(model->StringLabel(entity)) + ": " : "";
            assembly.warn("", number + text_of(check->CFail(i)));
        }
    }
    if (more > 0)
        assembly.warn("", "and " + std::to_string(more) + " more entities of " + options.input +
                              " that are not valid");
}

// Files that a STEP file names are read only where they lie beside it.
static void check_references(const Options &options, const Handle(XSControl_WorkSession) & session)
{
    STEPConstruct_ExternRefs references(session);
    references.LoadExternRefs();
    const std::size_t slash = options.input.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : options.input.substr(0, slash + 1);
    for (Standard_Integer i = 1; i <= references.NbExternRefs(); ++i) {
        const std::string name = references.FileName(i) ? references.FileName(i) : "";
        struct stat info;
        if (name.find('/') != std::string::npos || name.find('\\') != std::string::npos)
            throw Refused{options.input + ": names the file '" + name +
                          "', which does not lie beside it"};
        if (stat((folder + name).c_str(), &info) == 0 && !S_ISREG(info.st_mode))
            throw Refused{options.input + ": names the file '" + name +
                          "', which is not a regular file"};
    }
}

static void collect_ids(Document &document, const STEPCAFControl_Reader &reader)
{
    const Handle(XSControl_WorkSession) session = reader.Reader().WS();
    const Handle(Interface_InterfaceModel) model = session->Model();
    const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
    const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document.xcaf->Main());
    const STEPConstruct_Tool tool(session);
    const XCAFDoc_DataMapOfShapeLabel &labels = reader.GetShapeLabelMap();
    for (Standard_Integer i = 1; i <= model->NbEntities(); ++i) {
        const Handle(Standard_Transient) entity = model->Value(i);
        if (const auto use = Handle(StepRepr_NextAssemblyUsageOccurrence)::DownCast(entity);
            !use.IsNull()) {
            const TDF_Label label = STEPCAFControl_Reader::FindInstance(use, shapes, tool, labels);
            if (!label.IsNull())
                document.uses[entry_of(label)] = {text_of(use->Id()), text_of(use->Name())};
        } else if (const auto definition = Handle(StepBasic_ProductDefinition)::DownCast(entity);
                   !definition.IsNull()) {
            const Handle(Transfer_Binder) binder = process->Find(definition);
            if (binder.IsNull() || !binder->HasResult() || definition->Formation().IsNull() ||
                definition->Formation()->OfProduct().IsNull())
                continue;
            const TopoDS_Shape shape = TransferBRep::ShapeResult(process, binder);
            TDF_Label label;
            if (!shape.IsNull() && labels.IsBound(shape))
                label = labels.Find(shape);
            else if (!shape.IsNull())
                shapes->Search(shape, label, Standard_True, Standard_True, Standard_False);
            const Handle(StepBasic_Product) product = definition->Formation()->OfProduct();
            if (!label.IsNull())
                document.products[entry_of(label)] = {text_of(product->Id()),
                                                      text_of(product->Name())};
        }
    }
}

// Which entity made which shape, and the name that it gives it.
static void collect_entities(Document &document)
{
    const Handle(Interface_InterfaceModel) model = document.session->Model();
    const Handle(Transfer_TransientProcess) process =
        document.session->TransferReader()->TransientProcess();
    for (Standard_Integer i = 1; i <= model->NbEntities(); ++i) {
        const Handle(Standard_Transient) entity = model->Value(i);
        if (document.step &&
            !entity->IsKind(STANDARD_TYPE(StepShape_TopologicalRepresentationItem)) &&
            !entity->IsKind(STANDARD_TYPE(StepShape_SolidModel)))
            continue;
        const Handle(Transfer_Binder) binder = process->Find(entity);
        const TopoDS_Shape shape =
            binder.IsNull() ? TopoDS_Shape() : TransferBRep::ShapeResult(process, binder);
        if (shape.IsNull())
            continue;
        document.entities.emplace(identity(shape), i);
        const Handle(StepRepr_RepresentationItem) item =
            Handle(StepRepr_RepresentationItem)::DownCast(entity);
        const std::string name = item.IsNull() ? "" : text_of(item->Name());
        if (!name.empty() && name != "NONE")
            document.names[identity(shape)] = name;
    }
}

// AP203, AP214 and AP242 by the name of the schema.
static std::string protocol_of(const std::string &schema)
{
    for (const auto &[word, name] : {std::pair{"AUTOMOTIVE_DESIGN", "AP214"},
                                     {"CONFIG_CONTROL_DESIGN", "AP203"},
                                     {"AP203", "AP203"},
                                     {"AP214", "AP214"},
                                     {"AP242", "AP242"}})
        if (schema.find(word) != std::string::npos)
            return name;
    return schema;
}

// OpenCASCADE does not survive all that it finds: the first of it stands in the line of a crash.
static std::string making(const Assembly &assembly)
{
    return assembly.findings.empty() ? "making bodies"
                                     : "making bodies, after " + assembly.findings[0].text;
}

static void read_step(const Options &options, Document &document, Assembly &assembly,
                      Progress &progress)
{
    STEPCAFControl_Reader reader;
    reader.SetColorMode(Standard_True);
    reader.SetNameMode(Standard_True);
    reader.SetMatMode(Standard_True);
    reader.SetLayerMode(Standard_False);
    reader.SetPropsMode(Standard_False);
    reader.SetGDTMode(Standard_False);
    reader.SetViewMode(Standard_False);
    if (reader.ReadFile(options.input.c_str()) != IFSelect_RetDone)
        throw Refused{options.input +
                      ": not to be read as STEP: no entity that OpenCASCADE understands"};
    const Handle(XSControl_WorkSession) session = reader.Reader().WS();
    document.session = session;
    const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(session->Model());
    tell_failures(options, session->ModelCheckList(), assembly, model);
    check_references(options, session);
    const APIHeaderSection_MakeHeader header(model);
    if (header.HasFs() && header.NbSchemaIdentifiers() > 0)
        assembly.schema = protocol_of(text_of(header.SchemaIdentifiersValue(1)));
    if (header.HasFn())
        assembly.writer = text_of(header.OriginatingSystem());
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles);
    if (!lengths.IsEmpty())
        assembly.unit = text_of(lengths.First().ToCString());
    progress.step(making(assembly).c_str());
    if (!reader.Transfer(document.xcaf))
        throw Refused{options.input + ": no product with a shape"};
    tell_failures(options, document.session->TransferReader()->LastCheckList(), assembly, model);
    collect_ids(document, reader);
}

static void read_iges(const Options &options, Document &document, Assembly &assembly,
                      Progress &progress)
{
    IGESCAFControl_Reader reader;
    reader.SetColorMode(Standard_True);
    reader.SetNameMode(Standard_True);
    reader.SetLayerMode(Standard_False);
    if (reader.ReadFile(options.input.c_str()) != IFSelect_RetDone)
        throw Refused{options.input +
                      ": not to be read as IGES: no entity that OpenCASCADE understands"};
    document.step = false;
    document.session = reader.WS();
    const Handle(IGESData_IGESModel) model =
        Handle(IGESData_IGESModel)::DownCast(reader.WS()->Model());
    assembly.schema = "IGES";
    assembly.unit = text_of(model->GlobalSection().UnitName());
    assembly.writer = text_of(model->GlobalSection().SystemId());
    tell_failures(options, reader.WS()->ModelCheckList(), assembly, model);
    progress.step(making(assembly).c_str());
    if (!reader.Transfer(document.xcaf))
        throw Refused{options.input + ": no body and no surface"};
    tell_failures(options, document.session->TransferReader()->LastCheckList(), assembly, model);
}

Document read_document(const Options &options, Assembly &assembly, Progress &progress)
{
    Message::DefaultMessenger()->ChangePrinters().Clear();
    Document document;
    const Handle(XCAFApp_Application) application = XCAFApp_Application::GetApplication();
    application->NewDocument("BinXCAF", document.xcaf);
    assembly.source = options.input.substr(options.input.rfind('/') + 1);
    progress.step("reading");
    if (is_step(options.input))
        read_step(options, document, assembly, progress);
    else
        read_iges(options, document, assembly, progress);
    collect_entities(document);
    return document;
}

} // namespace cad
