#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: what is installed has its documents with links that lead somewhere, its licence and a manual page per command; a separate project builds
against it below DESTDIR; `uninstall`
takes all of it away; a package for Debian has the same (tests/slow)."""
import os
import re
import shutil
import subprocess
import sys

SOURCE = os.environ["SOURCE_DIR"]
BUILD = os.environ["BUILD_DIR"]
failures = []


def run(*words, cwd=None, **environment):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, cwd=cwd, env={**os.environ, **environment})
    if done.returncode != 0:
        failures.append(f"{' '.join(map(str, words))}: {done.returncode}\n{done.stdout[-600:]}{done.stderr[-600:]}")
    return done.stdout


def anchors(path):
    """Of the headings of a page, as forges make them."""
    with open(path, encoding="utf-8") as page:
        text = re.sub(r"```.*?```", "", page.read(), flags=re.S)
    heads = re.findall(r"^#+ +(.*?) *$", text, flags=re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def check_links(root):
    pages = [os.path.join(folder, name) for folder, _, names in os.walk(root) for name in names if name.endswith(".md")]
    n = 0
    for page in pages:
        with open(page, encoding="utf-8") as file:
            text = re.sub(r"```.*?```|`[^`]*`", "", file.read(), flags=re.S)
        for link in re.findall(r"\]\(([^) ]+)\)|<img src=\"([^\"]+)\"", text):
            target, _, anchor = (link[0] or link[1]).partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            path = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
            n += 1
            if not os.path.exists(path):
                failures.append(f"{page}: {target} is not there")
            elif anchor and path.endswith(".md") and anchor not in anchors(path):
                failures.append(f"{page}: {target} has no heading '{anchor}'")
    if n < 100:
        failures.append(f"{root}: {n} links in {len(pages)} pages")


def files(root):
    return [os.path.join(folder, name) for folder, _, names in os.walk(root) for name in names]


def check_tree(root):
    """root: has usr."""
    program = os.path.join(root, "usr/bin/raymap")
    told = run(program, "--version")
    commands = re.findall(r"^  ([a-z]+) ", run(program, "--help"), flags=re.M)
    pages = os.path.join(root, "usr/share/man/man1")
    for command in commands:
        if not any(name.startswith(f"raymap-{command}.1") for name in os.listdir(pages)):
            failures.append(f"no manual page of {command}")
    documents = os.path.join(root, "usr/share/doc/raymap")
    if not os.path.exists(os.path.join(documents, "LICENSE")):
        failures.append("no licence")
    if not os.access(os.path.join(root, "usr/share/raymap/jobs/slurm-trace.sh"), os.X_OK):
        failures.append("no jobs")
    check_links(documents)
    return told


def check_separate_project(root):
    """A plug-in of somebody else's, built against what is installed below DESTDIR, and run by the program there."""
    example = os.path.join(root, "usr/share/doc/raymap/examples/plugin")
    shutil.copytree(example, "project")
    run("cc", "-std=c17", "-O2", "-fPIC", "-shared", "-I" + os.path.join(root, "usr/include"), "rod.c", "-o", "rod.so", "-lm", cwd="project")
    program = os.path.join(root, "usr/bin/raymap")
    run(program, "trace", "scene.yaml", "--allow-plugins", "-n", "200", "-q", "-o", "rod.raymap", cwd="project")
    if "200 rays" not in run(program, "info", "rod.raymap", cwd="project"):
        failures.append("the plug-in traced nothing")


def check_library(root):
    """A program in C++ on what is installed below DESTDIR, found by pkg-config and by CMake."""
    found, = [os.path.dirname(path) for path in files(root) if path.endswith("pkgconfig/raymap.pc")]
    libraries = os.path.dirname(found)
    os.mkdir("consumer")
    shutil.copy(os.path.join(SOURCE, "tests/cli/library_consumer.cpp"), "consumer/main.cpp")
    flags = run("pkg-config", "--cflags", "--libs", "raymap", PKG_CONFIG_PATH=found).split()
    run("g++", "-std=c++11", "-pthread", "main.cpp", "-o", "by-pkg-config", *flags, cwd="consumer")
    with open("consumer/CMakeLists.txt", "w", encoding="utf-8") as file:
        file.write("cmake_minimum_required(VERSION 3.25)\nproject(consumer CXX)\nfind_package(raymap 0.1 REQUIRED)\n"
                   "find_package(Threads REQUIRED)\nadd_executable(by-cmake main.cpp)\n"
                   "target_link_libraries(by-cmake raymap::raymap Threads::Threads)\n")
    run("cmake", "-S", ".", "-B", ".", "-DCMAKE_PREFIX_PATH=" + os.path.join(root, "usr"), cwd="consumer")
    run("cmake", "--build", ".", cwd="consumer")
    if failures:
        return
    for program in ("by-pkg-config", "by-cmake"):
        told = run("./" + program, "../project/rod.raymap", "all", "ray/path_length", "2", cwd="consumer", LD_LIBRARY_PATH=libraries)
        if "rays 200 of 200" not in told:
            failures.append(f"{program}: {told}")
    page = run("man", "-l", os.path.join(root, "usr/share/man/man3/libraymap.3")) if shutil.which("man") else "raymap_read"
    if "raymap_read" not in page:
        failures.append(f"the library's page: {page}")


for folder in ("tree", "project", "consumer"):
    shutil.rmtree(folder, ignore_errors=True)
tree = os.path.abspath("tree")
check_links(SOURCE + "/docs")
run("cmake", "--install", BUILD, "--prefix", "/usr", DESTDIR=tree)
told = check_tree(tree)
check_separate_project(tree)
check_library(tree)
run("cmake", "-P", os.path.join(SOURCE, "cmake/Uninstall.cmake"), cwd=BUILD, DESTDIR=tree)
if files(tree):
    failures.append(f"left behind: {files(tree)[:5]}")

# CPack asks of each of hundreds of files what it is.
if int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1 and shutil.which("dpkg-shlibdeps"):
    run("cpack", "-G", "DEB", "-B", os.getcwd(), cwd=BUILD)
    package, = [name for name in os.listdir(".") if name.startswith("raymap_") and name.endswith(".deb")]
    run("dpkg", "-x", package, "tree")
    if check_tree(tree) != told:
        failures.append("the package has another version")
    fields = run("dpkg", "-f", package, "Depends")
    if "openmpi-bin" not in fields or "libhdf5" not in fields or "libembree" not in fields:
        failures.append(f"it depends on {fields}")
print("\n".join(failures) or "as promised")
sys.exit(bool(failures))
