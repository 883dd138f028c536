#!/usr/bin/env python3
"""Refuses an #include against the arrows of cmake/folders.txt, and files above 500 lines.

A folder of src/myrialux may include itself and whatever its line in the table reaches, directly or through others.
Only base may include TBB headers. Exit status 1 and one line "file:line: ..." for each offence.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCES = ROOT / "src" / "myrialux"
MAX_LINES = 500


def read_arrows():
    """Folder -> set of folders it may include, itself and transitive ones included."""
    direct = {}
    for line in (ROOT / "cmake" / "folders.txt").read_text().splitlines():
        if match := re.fullmatch(r"([a-z]+):(.*)", line):
            direct[match[1]] = match[2].split()
    reach = {}

    def visit(folder):
        if folder not in reach:
            reach[folder] = {folder}
            for below in direct[folder]:
                reach[folder] |= visit(below)
        return reach[folder]

    for folder in direct:
        visit(folder)
    return reach


def offences(arrows):
    for path in sorted(SOURCES.rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        folder = path.relative_to(SOURCES).parts[0]
        name = path.relative_to(ROOT)
        lines = path.read_text().splitlines()
        if folder not in arrows:
            yield f"{name}:1: folder '{folder}' is not in cmake/folders.txt"
            continue
        if len(lines) > MAX_LINES:
            yield f"{name}:{len(lines)}: {len(lines)} lines; a file has at most {MAX_LINES}"
        for number, line in enumerate(lines, 1):
            if match := re.match(r'\s*#\s*include\s+"myrialux/([a-z]+)/', line):
                if match[1] not in arrows[folder]:
                    yield f"{name}:{number}: {folder} may not include {match[1]} (cmake/folders.txt)"
            if re.match(r"\s*#\s*include\s+<(tbb|oneapi)/", line) and folder != "base":
                yield f"{name}:{number}: only base may include TBB; use myrialux/base/parallel.h"
            if re.match(r"\s*#\s*if\s+0\b", line):
                yield f"{name}:{number}: dead code behind #if 0"


def main():
    found = list(offences(read_arrows()))
    print("\n".join(found) if found else "include arrows: all hold")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
