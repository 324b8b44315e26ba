#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lines of code of the product, without blanks and comments, by layer and room:
`tests/count_lines.py [FOLDER]`, of this checkout or of another one's root."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
# Strings and characters are kept: a comment may not begin within them.
TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|/\*.*?\*/|//[^\n]*', re.S)


def code_lines(path):
    text = TOKEN.sub(lambda m: m[0] if m[0][0] != "/" else "\n" * m[0].count("\n"), path.read_text())
    return sum(1 for line in text.splitlines() if line.strip())


total = files = 0
for layer in ("src", "io", "analysis", "mpi"):
    rooms = {}
    for path in sorted((root / layer).rglob("*.[ch]*")):
        room = path.relative_to(root / layer).parts[0] if path.parent != root / layer else "."
        rooms.setdefault(room, []).append(code_lines(path))
    print(f"{layer:10} {sum(map(sum, rooms.values())):7} lines in {sum(map(len, rooms.values())):4} files")
    for room, lines in rooms.items():
        print(f"  {room:10} {sum(lines):5} lines in {len(lines):4} files")
        total, files = total + sum(lines), files + len(lines)
print(f"{'all':10} {total:7} lines in {files:4} files")
