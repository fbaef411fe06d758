#!/usr/bin/python3
"""The documents, the scenes and the program agree: on keys, on options, on what is a scene, on where things stand."""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import case as c

sys.path.insert(0, str(c.SOURCE / "tests"))
import layering  # noqa: E402

COLUMNS = ("key", "type", "unit", "default", "range", "meaning")
TYPE = re.compile(r"(bool|integer|number|text|choice|choice list|pair list|name list|map list)(\[\d\])?")
MOST_LINES = 210  # of README.md: a newcomer's page
BUILT = re.compile(r"(build\w*|out|\.git|__pycache__)")
# What a document's scene leaves out because it shows one thing.
REST_OF_SCENE = {"particle_spacing": "particle_spacing: 0.02\n", "end_time": "end_time: 1.0\n",
                 "fluid": "fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]}\n"}


def documents():
    """Every Markdown file of the source tree and its text."""
    paths = sorted(path for path in c.SOURCE.rglob("*.md")
                   if not any(BUILT.fullmatch(part) for part in path.relative_to(c.SOURCE).parts))
    return {str(path.relative_to(c.SOURCE)): path.read_text(encoding="utf-8") for path in paths}


def code_blocks(text, language=r"\w*"):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def key_rows(case):
    """The table that `halocline keys` prints, by its columns."""
    lines = case.call(["keys"]).splitlines()
    starts = [lines[0].index(name) for name in COLUMNS]
    ends = [*starts[1:], None]
    return [[line[start:end].strip() for start, end in zip(starts, ends)] for line in lines[1:]]


def keys(case, _):
    rows = key_rows(case)
    c.expect(len(rows) > 30, f"halocline keys lists {len(rows)} keys only")
    for row in rows:
        for name, cell in zip(COLUMNS, row):
            c.expect(cell, f"halocline keys: {row[0]} has no {name}")
        c.expect(TYPE.fullmatch(row[1]), f"halocline keys: {row[0]} has the type {row[1]}")
        c.expect(len(row[5].split()) >= 2, f"halocline keys: {row[0]} is not explained: {row[5]}")
    names = [row[0] for row in rows]
    c.expect(len(set(names)) == len(names), "halocline keys lists a key twice")
    return f"{len(rows)} keys have type, unit, default, range and meaning"


def named_keys(case, _):
    """Dotted names in code that begin like a key, and what is passed to --set, are keys or maps of keys."""
    known = set()
    for name in (row[0] for row in key_rows(case)):
        parts = name.split(".")
        known |= {".".join(parts[:k + 1]).removesuffix("[]") for k in range(len(parts))} | {name}
    maps = {name.split(".")[0] for name in known if "." in name}
    total = 0
    for document, text in documents().items():
        code = "\n".join([*code_blocks(text), *re.findall(r"`([^`\n]+)`", text)])
        named = {name for name in re.findall(r"(?<![\w./])[a-z]\w*(?:\[\d*\])?(?:\.[a-z]\w*(?:\[\d*\])?)+", code)
                 if re.split(r"[.\[]", name)[0] in maps and not re.search(r"\.(c|h|py|md|png|csv|yaml)$", name)}
        named |= set(re.findall(r"--set[=\s]+'?([a-z][\w.\[\]]*)=", text))
        for name in sorted(named):
            c.expect(re.sub(r"\[\d*\]", "[]", name).removesuffix("[]") in known,
                     f"{document} names {name}, which is no key")
        total += len(named)
    c.expect(total > 40, f"the documents name {total} keys only")
    return f"{total} keys that the documents name exist"


def options_of(text):
    return set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))


def options(case, _):
    """README.md lists the options that each command's --help tells, and no document uses others with it."""
    commands = re.findall(r"^  (\w+) ", case.call(["--help"]), re.MULTILINE)
    c.expect("run" in commands and "keys" in commands, f"halocline --help tells of the commands {commands}")
    helps = {command: case.call([command, "--help"]) for command in commands}
    helped = {command: options_of(text) - {"--help"} for command, text in helps.items()}
    texts = documents()
    listing = next(block for block in code_blocks(texts["README.md"]) if "COMMAND [ARGUMENTS]" in block)
    for command in commands:
        lines = re.search(rf"^{command}\b.*\n(?: .*\n)*", listing, re.MULTILINE)
        c.expect(lines, f"README.md does not list the command {command}")
        found = options_of(lines.group())
        found |= {option for letter, option in re.findall(r"-(\w), (--[\w-]+)", helps[command])
                  if re.search(rf"(?<!\w)-{letter}\b", lines.group())}
        c.expect(found == helped[command],
                 f"README.md lists {sorted(found)} for {command}, --help {sorted(helped[command])}")
    for document, text in texts.items():
        for command, rest in re.findall(r"halocline (\w+)([^\n`|]*)", text):
            unknown = options_of(rest) - helped.get(command, set()) - {"--help"}
            c.expect(command not in helped or not unknown, f"{document} uses {sorted(unknown)} with halocline {command}")
    return f"the options of {len(commands)} commands are those of README.md"


def shown_scenes(folder):
    """The scenes that the documents show, as files in a folder that has the files they name; parts made whole."""
    paths = []
    for parts in ("meshes", "rest_states"):
        shutil.copytree(c.SOURCE / "scenes" / parts, folder / parts)
    for document, text in documents().items():
        for table in code_blocks(text, "csv"):
            (folder / "paddle.csv").write_text(table, encoding="utf-8")
        for block in code_blocks(text, "yaml"):
            rest = [line for key, line in REST_OF_SCENE.items() if not re.search(rf"^{key}:", block, re.MULTILINE)]
            paths.append(folder / f"{document.replace('/', '_')}_{len(paths)}.yaml")
            paths[-1].write_text("".join([block, *rest]), encoding="utf-8")
    return paths


def examples(case, _):
    """Every scene, and every one that the documents show, is valid and has no keys to warn of."""
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        scenes, shown = sorted((c.SOURCE / "scenes").glob("*.yaml")), shown_scenes(Path(folder))
        for path in [*scenes, *shown]:
            text = case.call(["check", path])
            c.expect("is not used" not in text, f"{path}:\n{text}")
    c.expect(len(shown) > 5, f"the documents show {len(shown)} scenes only")
    return f"{len(scenes)} scenes and {len(shown)} that the documents show are valid"


def reading(case, _):
    """README.md's scene runs, and its Python reads what it and the demo leave."""
    readme = documents()["README.md"]
    scene, = code_blocks(readme, "yaml")
    program, = code_blocks(readme, "python")
    with tempfile.TemporaryDirectory(dir=case.folder) as name:
        folder = Path(name)
        (folder / "obstacle.yaml").write_text(scene, encoding="utf-8")
        coarse = ["--set", "particle_spacing=0.05", "--quiet", "--steps", "4"]
        case.call(["run", folder / "obstacle.yaml", "--steps", "4", "--quiet", "-o", folder / "out/obstacle"])
        case.call(["run", c.SOURCE / "scenes/dam_break.yaml", *coarse, "-o", folder / "out/dam_break"])
        done = subprocess.run([sys.executable, "-c", program], cwd=folder, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=120, check=False)
    c.expect(done.returncode == 0, f"README.md's Python fails:\n{done.stdout[-4000:]}")
    c.expect("front at 0.7" in done.stdout and "4 steps" in done.stdout, f"README.md's Python prints:\n{done.stdout}")
    return "README.md's scene runs and its Python reads the results"


def anchors_of(text):
    """The names by which headings are linked to, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(_case, _steps):
    """Every link inside the source tree leads somewhere, and README.md stays a page for a newcomer."""
    texts = documents()
    total = 0
    for document, text in texts.items():
        prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)\s]+)\)", prose):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            found = ((c.SOURCE / document).parent / path).resolve() if path else c.SOURCE / document
            c.expect(found.exists() and c.SOURCE in [found, *found.parents], f"{document} links to {target}: no such file")
            if anchor:
                name = str(found.relative_to(c.SOURCE))
                c.expect(anchor in anchors_of(texts.get(name, "")), f"{document} links to {target}: no such heading")
            total += 1
    c.expect(total > 20, f"the documents have {total} links among themselves only")
    lines = texts["README.md"].count("\n")
    c.expect(lines <= MOST_LINES, f"README.md has {lines} lines, more than {MOST_LINES}")
    return f"{total} links of {len(texts)} documents lead somewhere; README.md has {lines} lines"


def rooms(_case, _steps):
    """src/README.md's table of rooms is that of the layering test, as far as there are such folders."""
    there = {folder.name for folder in (c.SOURCE / "src").iterdir() if folder.is_dir()}
    table = re.findall(r"^\| `(\w+)/` \| .+ \| ([^|]+) \|$", documents()["src/README.md"], re.MULTILINE)
    c.expect([room for room, _ in table] == [room for room in layering.ROOMS if room in there],
             f"src/README.md lists the rooms {[room for room, _ in table]}, tests/layering.py {list(layering.ROOMS)}")
    for room, cell in table:
        may = layering.ROOMS[room]
        may = may if isinstance(may, str) else ", ".join(r for r in may if r in there) or "nothing of ours"
        c.expect(cell.strip() == may, f"src/README.md says that {room}/ may include {cell}, tests/layering.py {may}")
    return f"{len(table)} rooms are described as they are checked"


if __name__ == "__main__":
    c.main(__doc__, {"keys": keys, "named_keys": named_keys, "options": options, "examples": examples,
                     "reading": reading, "links": links, "rooms": rooms})
