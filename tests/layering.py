#!/usr/bin/python3
"""Checks that the sources keep to the rooms of the architecture.

    layering.py [ROOT]              names every offence as file:line, exit code 1 if there is one
    layering.py --self-test [ROOT]  plants offences in a temporary copy and expects each of them to be found

A room (a folder of src/) may include what its row names, and what those may include in turn: never sideways, never
upward. Nor may files include each other in a circle; a header and the source of its name are one file here.
MPI is called only in comm/, HDF5 only in io/, METIS only in domain/. Needs nothing but Python.
"""

import re
import shutil
import sys
import tempfile
from pathlib import Path

# The one table: a room, and what it may include directly.
ROOMS = {
    "base": [],
    "comm": ["base"],
    "particles": ["base"],
    "geometry": ["base"],
    "scene": ["base"],
    "space": ["base", "particles"],
    "state": ["particles", "space"],
    "domain": ["base", "comm", "particles", "space"],
    "sph": ["base", "particles", "space"],
    "boundary": ["sph"],
    "world": ["boundary", "domain", "state"],
    "rigid": ["world", "geometry"],
    "sources": ["world", "rigid", "geometry"],
    "solver": ["world", "rigid"],
    "gauges": ["scene", "sph", "geometry", "comm", "solver"],
    "stepping": ["solver", "state"],
    "setup": ["scene", "geometry", "domain", "sources", "rigid", "solver", "stepping"],
    "window": ["setup", "domain", "state"],
    "simulation": ["stepping", "setup", "sources", "window", "rigid", "solver", "domain", "state"],
    "io": ["state", "scene", "comm"],
    "job": ["simulation", "io", "gauges"],
    "api": ["simulation", "job"],
    "app": "everything",
}

# A library: its headers, its identifiers, the room that owns it, and the identifiers that others may write too
# (the types that comm.h's structures show, and what io/ needs to hand a communicator to HDF5).
LIBRARIES = [
    ("MPI", re.compile(r"mpi(-ext|io)?\.h"), re.compile(r"\bP?MPIX?_\w+"), "comm",
     {"*": {"MPI_Comm", "MPI_Request"}, "io": {"MPI_INFO_NULL"}}),
    ("HDF5", re.compile(r"hdf5(_hl)?\.h|H5\w*\.h"), re.compile(r"\bH5[A-Z]\w*|\b(hid_t|hsize_t|hssize_t|herr_t)\b"),
     "io", {}),
    ("METIS", re.compile(r"(par)?metis\.h"), re.compile(r"\b(Par)?METIS_\w+"), "domain", {}),
]

TOKEN = re.compile(
    r"""//(?:\\\n|[^\n])*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.DOTALL)
INCLUDE = re.compile(r"""^[ \t]*(?:\#|%:|\?\?=)[ \t]*(include|include_next|import|embed)\b[ \t]*([^\n]*)""",
                     re.MULTILINE)
SUFFIXES = {".c", ".h", ".def", ".inc"}


def closures():
    """What each room may include in the end; a table with a cycle is no table of layers."""
    done = {}

    def visit(room, path):
        if room in path:
            sys.exit(f"layering: the table has a cycle: {' -> '.join([*path, room])}")
        if room not in done:
            direct = [r for r in ROOMS if r not in (room, "api")] if ROOMS[room] == "everything" else ROOMS[room]
            done[room] = {room}.union(*(visit(r, [*path, room]) for r in direct))
        return done[room]

    for room in ROOMS:
        visit(room, [])
    return done


def blank(text, strings):
    """The text with comments (and strings) blanked out, line numbers kept."""

    def keep_lines(match):
        token = match.group()
        if token[0] in "\"'" and not strings:
            return token
        return re.sub(r"[^\n]", " ", token)

    return TOKEN.sub(keep_lines, text)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def room_of(path, root):
    """The room of a file, "include" for a public header, None for what is not ours."""
    try:
        parts = path.resolve().relative_to(root).parts
    except ValueError:
        return None
    if parts[0] == "src":
        return parts[1] if len(parts) > 2 else "src"
    return parts[0]


def find_include(path, target, root):
    """Quote, name and file of an #include: the file None if it is not ours, all None if it is computed."""
    match = re.match(r"""(["<])([^">]+)[">]""", target)
    if not match:
        return None, None, None
    quote, name = match.groups()
    places = [root / "src" / name, root / "include" / name]
    if quote == '"':
        places.insert(0, path.parent / name)
    return quote, name, next((place for place in places if place.is_file()), None)


def check_include(path, room, target, root, allowed):
    """Why this #include may not stand here, or None."""
    quote, name, found = find_include(path, target, root)
    if not name:
        return f"#include {target.strip()}: a computed include cannot be checked"
    for library, headers, _, owner, _ in LIBRARIES:
        if headers.fullmatch(Path(name).name) and room != owner:
            return f"includes {name}, but only {owner}/ may use {library}"
    first = name.split("/")[0]
    other = room_of(found, root) if found else first if first in ROOMS else None
    if other == "include" or (other is None and quote == "<"):
        return None
    if other is None:
        return f'includes "{name}", which is neither in src nor in include'
    if room == "include":
        return f"a public header includes {name} of src/{other}/"
    if other not in allowed[room]:
        return f"includes {name}, but {room}/ may not include {other}/"
    return None


def find_circles(edges):
    """A circle of every set of nodes that reach each other, from its first node on and back to it.

    edges: {node: {node it includes: where}}.
    """
    def path(start, goal):
        before, queue = {start: None}, [start]
        for node in queue:
            if goal in edges.get(node, ()):
                way = [goal]
                while node is not None:
                    way.append(node)
                    node = before[node]
                return way[::-1]
            for other in sorted(edges.get(node, ())):
                if other not in before:
                    before[other] = node
                    queue.append(other)
        return None

    circles, done = [], set()
    for node in sorted(edges):
        circle = node not in done and path(node, node)
        if circle:
            circles.append(circle)
            done |= {other for other in edges if path(node, other) and path(other, node)}
    return circles


def check(root):
    """All offences, as (file, line, reason)."""
    root = Path(root).resolve()
    allowed = closures()
    offences = []
    edges = {}
    for path in sorted([*(root / "src").rglob("*"), *(root / "include/halocline").rglob("*")]):
        if not path.is_file() or path.suffix not in SUFFIXES:
            continue
        shown, room = path.relative_to(root), room_of(path, root)
        if room != "include" and room not in ROOMS:
            offences.append((shown, 1, f"{room}/ is not a room of the table in tests/layering.py"))
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        directives = blank(text, strings=False)
        for match in INCLUDE.finditer(directives):
            reason = check_include(path, room, match.group(2), root, allowed)
            if reason:
                offences.append((shown, line_of(directives, match.start(1)), reason))
            found = find_include(path, match.group(2), root)[2]
            if found and room_of(found, root) in ROOMS and room in ROOMS:
                other = found.resolve().relative_to(root / "src").with_suffix("").as_posix()
                node = path.relative_to(root / "src").with_suffix("").as_posix()
                if other != node:
                    edges.setdefault(node, {}).setdefault(other, (shown, line_of(directives, match.start(1))))
        code = blank(text, strings=True)
        for library, _, identifiers, owner, exceptions in LIBRARIES:
            if room == owner:
                continue
            free = exceptions.get("*", set()) | exceptions.get(room, set())
            for match in identifiers.finditer(code):
                if match.group() not in free:
                    offences.append((shown, line_of(code, match.start()),
                                     f"{match.group()}, but only {owner}/ may use {library}"))
    for circle in find_circles(edges):
        offences.append((*edges[circle[0]][circle[1]], f"files include each other: {' -> '.join(circle)}"))
    return offences


# What the self-test plants: a file, its text, the line of the offence (None: there is none); x.h and y.h are there,
# empty, in every room, and may have texts too.
PLANTS = [
    ("src/sph/x.c", '#include "space/x.h"\n#include "base/x.h"\n#include "sph/y.h"\n#include "y.h"\n', None),
    ("src/sph/x.c", '\n#include "comm/x.h"\n', 2),
    ("src/sph/x.c", '/* a\n comment */ \n#  include "domain/x.h"\n', 3),
    ("src/sph/x.c", '#include "../domain/x.h"\n', 1),
    ("src/sph/x.c", "#include <domain/x.h>\n", 1),
    ("src/sph/x.c", '#include "boundary/x.h"\n', 1),
    ("src/base/x.c", '#include "halocline/x.h"\n#include <stdio.h>\n', None),
    ("src/base/x.c", '#include "particles/x.h"\n', 1),
    ("src/space/x.h", '#include "sph/x.h"\n', 1),
    ("src/space/x.h", '#define X "sph/x.h"\n#include X\n', 2),
    ("src/space/x.h", '#include \\\n  "sph/x.h"\n', 1),
    ("src/space/x.h", '#include "nowhere/x.h"\n', 1),
    ("src/particles/x.def", '#include "space/x.h"\n', 1),
    ("src/scene/x.c", '#include "geometry/x.h"\n', 1),
    ("src/geometry/x.c", '#include "scene/x.h"\n', 1),
    ("src/io/x.c", '#include "solver/x.h"\n', 1),
    ("src/gauges/x.c", '#include "setup/x.h"\n', 1),
    ("src/stepping/x.c", '#include "sph/x.h"\n#include "comm/x.h"\n', None),
    ("src/stepping/x.c", '#include "setup/x.h"\n', 1),
    ("src/solver/x.c", '#include "io/x.h"\n', 1),
    ("src/setup/x.c", '#include "app/x.h"\n', 1),
    ("src/app/x.c", '#include "io/x.h"\n#include "solver/x.h"\n#include "base/x.h"\n', None),
    ("src/app/x.c", "#include <mpi.h>\n", 1),
    ("src/app/x.c", '#include "api/x.h"\n', 1),
    ("src/api/x.c", '#include "job/x.h"\n#include "halocline/x.h"\n', None),
    ("src/api/x.c", '#include "app/x.h"\n', 1),
    ("src/simulation/x.c", '#include "io/x.h"\n', 1),
    ("src/job/x.c", '#include "io/x.h"\n#include "simulation/x.h"\n', None),
    ("src/job/x.c", '#include "app/x.h"\n', 1),
    ("src/api/x.c", "#include <mpi.h>\n", 1),
    ("src/domain/x.c", "int f(void) {\n  return MPI_Barrier(c);\n}\n", 2),
    ("src/domain/x.c", "MPI_Comm c;\nMPI_Request *r;\n// MPI_Send\nconst char *s = \"MPI_Send\";\n", None),
    ("src/domain/x.c", "int (*f)(void) = PMPI_Wait;\n", 1),
    ("src/domain/x.c", "char c = '\"';\nint i = MPI_Wait();\nchar d = '\"';\n", 2),
    ("src/domain/x.c", "#include <metis.h>\nint i = METIS_OK;\n", None),
    ("src/solver/x.c", "#include <metis.h>\n", 1),
    ("src/comm/x.c", "#include <mpi.h>\nint i = MPI_SUCCESS;\n", None),
    ("src/io/x.c", "#include <hdf5.h>\nhid_t f;\nvoid *i = MPI_INFO_NULL;\n", None),
    ("src/io/x.c", "int i = MPI_Barrier(c);\n", 1),
    ("src/state/x.c", "\n\nhid_t f;\n", 3),
    ("src/state/x.c", "int i = H5Fclose(f);\n", 1),
    ("src/state/x.c", "#include <hdf5.h>\n", 1),
    ("src/nonsense/x.c", "int i;\n", 1),
    ("include/halocline/x.h", '#include "base/x.h"\n', 1),
    ("include/halocline/x.h", "#include <mpi.h>\n", 1),
    ("include/examples/x.c", "#include <mpi.h>\nMPI_Fint f;\n", None),
    ("include/halocline/x.h", '#include "halocline/y.h"\n#include <stdint.h>\n', None),
    ("src/sph/x.c", '#include "x.h"\n#include "y.h"\n', None),
    ("src/sph/x.c", '#include "x.h"\n\n#include "sph/y.h"\n', 3, {"src/sph/y.h": '#include "x.h"\n'}),
    ("src/sph/x.c", '#include "y.h"\n', None, {"src/sph/y.h": '#include "z.h"\n', "src/sph/z.h": ""}),
    ("src/sph/x.c", '#include "y.h"\n', 1,
     {"src/sph/y.h": '#include "z.h"\n', "src/sph/z.h": '#include "z.h"\n#include "../sph/x.h"\n'}),
    ("src/sph/x.c", '/* #include "y.h" */\n', None, {"src/sph/y.h": '#include "x.h"\n'}),
]


def self_test(root):
    """Every plant must be found where it stands, in the copied tree and nowhere else."""
    root = Path(root).resolve()
    wrong = 0
    with tempfile.TemporaryDirectory() as temporary:
        for number, (name, text, line, *more) in enumerate(PLANTS):
            copy = Path(temporary) / str(number)
            for folder in ("src", "include"):
                shutil.copytree(root / folder, copy / folder)
            before = set(check(copy))
            for room in ROOMS:
                for header in ("x.h", "y.h"):
                    (copy / "src" / room).mkdir(exist_ok=True)
                    (copy / "src" / room / header).write_text("")
            for header in ("x.h", "y.h"):
                (copy / "include/halocline" / header).write_text("")
            (copy / name).parent.mkdir(exist_ok=True)
            for file, content in {name: text, **(more[0] if more else {})}.items():
                (copy / file).write_text(content)
            found = {(str(file), at) for file, at, _ in set(check(copy)) - before}
            expected = set() if line is None else {(name, line)}
            if found != expected:
                wrong += 1
                print(f"layering self-test: in {name}:\n{text}expected {expected or 'nothing'}, found {found or 'nothing'}")
            shutil.rmtree(copy)
    print(f"layering self-test: {len(PLANTS) - wrong} of {len(PLANTS)} plants judged rightly")
    return 1 if wrong else 0


def main(arguments):
    testing = "--self-test" in arguments
    rest = [a for a in arguments if a != "--self-test"]
    if len(rest) > 1 or any(a.startswith("-") for a in rest):
        print(__doc__)
        return 2
    root = Path(rest[0]) if rest else Path(__file__).resolve().parent.parent
    if not (root / "src").is_dir():
        print(f"layering: {root} has no src")
        return 2
    if testing:
        return self_test(root)
    offences = check(root)
    for file, line, reason in offences:
        print(f"{file}:{line}: {reason}")
    files = sum(1 for p in (root / "src").rglob("*") if p.suffix in SUFFIXES)
    print(f"layering: {len(offences)} offences in {files} files" if offences else f"layering: {files} files keep to their rooms")
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
