// SPDX-License-Identifier: MIT
//
// A STEP or IGES file read into OpenCASCADE's document, with what that document does not keep: the
// ids that the file itself gives products and their uses, names of faces and bodies, and the
// numbers of entities.
#ifndef CAD_DOCUMENT_HPP
#define CAD_DOCUMENT_HPP

#include "assembly.hpp"
#include "progress.hpp"

#include <TDF_Label.hxx>
#include <TDocStd_Document.hxx>
#include <XSControl_WorkSession.hxx>

#include <map>

namespace cad
{

// Of a product (a label that others refer to), or of a use of one (a component of an assembly).
struct Named {
    std::string id, name;
};

template <class Value> using ByShape = std::map<const void *, Value>; // by the address of a TShape

inline const void *identity(const TopoDS_Shape &shape)
{
    return shape.TShape().get();
}

struct Document {
    Handle(TDocStd_Document) xcaf;
    Handle(XSControl_WorkSession) session;
    bool step = true;
    std::map<std::string, Named> products, uses; // by the entry of the label
    ByShape<std::string> names;                  // of faces and bodies
    ByShape<int> entities;                       // that made a shape

    // "#123" of the entity that a shape was made of, or "".
    std::string entity_of(const TopoDS_Shape &shape) const;
};

std::string entry_of(const TDF_Label &label);

// UTF-8 whatever the file had, without blanks at the ends.
std::string text_of(const char *text);

// Throws Refused.
Document read_document(const Options &options, Assembly &assembly, Progress &progress);

} // namespace cad

#endif
