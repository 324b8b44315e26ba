// SPDX-License-Identifier: MIT
//
// raymap-step: a STEP or IGES file as meshes with true surfaces and assembly.json. A program of its
// own, so that nobody needs OpenCASCADE who does not bring CAD files, and a file that crashes it
// takes nothing along.
#include "document.hpp"
#include "touching.hpp"
#include "tree.hpp"
#include "write.hpp"

#include <Standard_Failure.hxx>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

static const char usage[] =
    "usage: raymap-step FILE FOLDER [--chord MM] [--angle DEGREES] [--no-touching] [--seconds N] "
    "[--quiet]\n"
    "\n"
    "Reads STEP (AP203, AP214, AP242) or IGES and writes assembly.json and a PLY file of each "
    "shape into FOLDER, which must\n"
    "be new or empty.\n"
    "\n"
    "  --chord MM        how far triangles may lie from what they stand for; without it 0.001 of "
    "each shape's diagonal\n"
    "  --angle DEGREES   the greatest angle between neighbouring chords of an edge or a face (10)\n"
    "  --no-touching     do not look for faces of different parts that touch\n"
    "  --seconds N       give up after so long (an hour, and more of files above 18 MB)\n"
    "  --quiet           say nothing of what goes on\n";

namespace cad
{

void Assembly::warn(const std::string &part, const std::string &text)
{
    findings.push_back({part, text});
}

static bool number_of(const char *text, double least, double most, double &value)
{
    char *end = nullptr;
    value = text ? std::strtod(text, &end) : 0;
    return text && end != text && *end == '\0' && value >= least && value <= most;
}

static Options options_of(int count, char **words)
{
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        const char *next = i + 1 < count ? words[i + 1] : nullptr;
        if (word == "--quiet") {
            options.quiet = true;
        } else if (word == "--no-touching") {
            options.touching = false;
        } else if (word == "--chord") {
            if (!number_of(next, 1e-6, 1e6, options.chord)) // OpenCASCADE's own least: 1e-7
                throw Refused{"--chord takes a length in mm, from 1e-6 to 1e6", 2};
            ++i;
        } else if (word == "--angle") {
            if (!number_of(next, 0.1, 90, options.angle))
                throw Refused{"--angle takes degrees, from 0.1 to 90", 2};
            ++i;
        } else if (word == "--seconds") {
            if (!number_of(next, 0.001, 1e6, options.seconds))
                throw Refused{"--seconds takes a time, from 0.001 to 1e6", 2};
            ++i;
        } else if (word.size() > 1 && word[0] == '-') {
            throw Refused{word + ": no such option; raymap-step --help tells those that are", 2};
        } else if (options.input.empty()) {
            options.input = word;
        } else if (options.folder.empty()) {
            options.folder = word;
        } else {
            throw Refused{word + ": one file and one folder are taken", 2};
        }
    }
    if (options.folder.empty())
        throw Refused{"a file and a folder are wanted; raymap-step --help", 2};
    return options;
}

static void convert(const Options &options)
{
    Progress progress(options.input, options.quiet);
    bound_process(options.input, static_cast<unsigned>(std::ceil(options.seconds)));
    Assembly assembly;
    const Document document = read_document(options, assembly, progress);
    build_tree(options, document, assembly, progress);
    if (options.touching)
        find_touching(assembly, progress);
    progress.step("writing");
    write_assembly(options, assembly);
    if (options.quiet)
        return;
    std::size_t triangles = 0;
    for (const Shape &shape : assembly.shapes)
        triangles += shape.mesh.triangles.size();
    char chord[64];
    std::snprintf(chord, sizeof chord, options.chord > 0 ? "%g mm" : "%g of each shape's size",
                  options.chord > 0 ? options.chord : Options::chord_of_size);
    std::printf("%s: %s in %s, %zu shapes, %zu triangles (chord %s, angle %g degrees), %zu "
                "touching pairs\n",
                printable(options.input).c_str(), printable(assembly.schema).c_str(),
                printable(assembly.unit).c_str(), assembly.shapes.size(), triangles, chord,
                options.angle, assembly.touching.size());
    for (const Finding &finding : assembly.findings)
        std::printf("  %s%s%s\n", printable(finding.part).c_str(), finding.part.empty() ? "" : ": ",
                    printable(finding.text).c_str());
}

} // namespace cad

int main(int count, char **words)
{
    if (count == 2 && (std::strcmp(words[1], "--help") == 0 || std::strcmp(words[1], "-h") == 0)) {
        std::fputs(usage, stdout);
        return 0;
    }
    std::string text, input = "raymap-step";
    int status = 5;
    try {
        const cad::Options options = cad::options_of(count, words);
        input = options.input;
        cad::convert(options);
        return 0;
    } catch (const cad::Refused &refused) {
        text = refused.text;
        status = refused.status;
    } catch (const Standard_Failure &failure) {
        text = input + ": OpenCASCADE: " + failure.DynamicType()->Name() + " " +
               failure.GetMessageString();
        status = 3;
    } catch (const std::bad_alloc &) {
        text = input + ": not enough memory";
    } catch (const std::exception &failure) {
        text = input + ": " + failure.what();
    }
    std::fprintf(stderr, "raymap-step: %s\n", cad::printable(text).c_str());
    return status;
}
