#!/usr/bin/python3
"""README.md, the scenes and the program agree: on keys, on options, on what is a scene."""

import re
import tempfile
from pathlib import Path

import case as c

COLUMNS = ("key", "type", "unit", "default", "range", "meaning")
TYPE = re.compile(r"(bool|integer|number|text|choice|choice list|pair list|name list|map list)(\[\d\])?")


def readme():
    return (c.SOURCE / "README.md").read_text(encoding="utf-8")


def code_blocks(language=r"\w*"):
    return re.findall(rf"^```{language}\n(.*?)^```", readme(), re.MULTILINE | re.DOTALL)


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


def readme_keys(case, _):
    """Dotted names of README.md that begin like a key, and what it passes to --set, are keys or maps of keys."""
    known = set()
    for name in (row[0] for row in key_rows(case)):
        parts = name.split(".")
        known |= {".".join(parts[:k + 1]).removesuffix("[]") for k in range(len(parts))} | {name}
    maps = {name.split(".")[0] for name in known if "." in name}
    code = "\n".join([*code_blocks(), *re.findall(r"`([^`\n]+)`", readme())])
    named = {name for name in re.findall(r"[a-z]\w*(?:\[\d*\])?(?:\.[a-z]\w*(?:\[\d*\])?)+", code)
             if re.split(r"[.\[]", name)[0] in maps}
    named |= set(re.findall(r"--set[= ]'?([a-z][\w.\[\]]*)=", code))
    c.expect(len(named) > 5, f"README.md names {len(named)} keys only: {sorted(named)}")
    for name in sorted(named):
        c.expect(re.sub(r"\[\d*\]", "[]", name).removesuffix("[]") in known, f"README.md names {name}, which is no key")
    return f"{len(named)} keys that README.md names exist"


def options_of(text):
    return set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))


def readme_options(case, _):
    """README.md lists the options that each command's --help tells, and uses no others with it."""
    commands = re.findall(r"^  (\w+) ", case.call(["--help"]), re.MULTILINE)
    c.expect("run" in commands and "keys" in commands, f"halocline --help tells of the commands {commands}")
    helps = {command: case.call([command, "--help"]) for command in commands}
    helped = {command: options_of(text) - {"--help"} for command, text in helps.items()}
    listing = next(block for block in code_blocks() if "COMMAND [ARGUMENTS]" in block)
    for command in commands:
        lines = re.search(rf"^{command}\b.*\n(?: .*\n)*", listing, re.MULTILINE)
        c.expect(lines, f"README.md does not list the command {command}")
        found = options_of(lines.group())
        found |= {option for letter, option in re.findall(r"-(\w), (--[\w-]+)", helps[command])
                  if re.search(rf"(?<!\w)-{letter}\b", lines.group())}
        c.expect(found == helped[command],
                 f"README.md lists {sorted(found)} for {command}, --help {sorted(helped[command])}")
    for command, rest in re.findall(r"halocline (\w+)([^\n`|]*)", readme()):
        unknown = options_of(rest) - helped.get(command, set()) - {"--help"}
        c.expect(command not in helped or not unknown, f"README.md uses {sorted(unknown)} with halocline {command}")
    return f"the options of {len(commands)} commands are those of README.md"


def examples(case, _):
    """Every scene, and every one that README.md shows, is valid and has no keys to warn of."""
    shown = code_blocks("yaml")
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        paths = sorted((c.SOURCE / "scenes").glob("*.yaml"))
        for number, text in enumerate(shown):
            paths.append(Path(folder) / f"shown_{number}.yaml")
            paths[-1].write_text(text, encoding="utf-8")
        for path in paths:
            text = case.call(["check", path])
            c.expect("is not used" not in text, f"{path}:\n{text}")
    c.expect(shown, "README.md shows no scene")
    return f"{len(paths)} scenes are valid, {len(shown)} of them shown by README.md"


if __name__ == "__main__":
    c.main(__doc__, {"keys": keys, "readme_keys": readme_keys, "readme_options": readme_options, "examples": examples})
