#!/usr/bin/env python3
"""Checks that no files import each other in a circle, that crates use only what ARCHITECTURE.md lets them use, and that all
tests are run.
Needs Python 3.11, nothing else.

    tools/check_structure.py [--graph CRATE]

Rooms. A module of a crate's root and its submodules (`training.rs` and `training/`) are one room: a parent lends its
children its types, and they may import each other. Between rooms there must be no circle. A room imports another if it
names something of it by a path from `crate` or `super`, in a `use` or elsewhere. A name that the root exports counts as its
module's; what the root itself defines makes the root a room, whose `mod` and `pub use` lines alone are no imports. Methods
that are called without naming their module are not seen.

Crates. The table in ARCHITECTURE.md says what each crate uses. Its `[dependencies]` name those crates and no others; all of
them, and its `[dev-dependencies]` too, stand below it in the table.

Tests. Each file of a crate's `tests` is run: it is a module of `tests/main.rs`, or a program that `Cargo.toml` names.

Prints what is wrong, one line each with the circle, and exits with 1 if there is anything. `--graph` prints a crate's rooms.
"""

import re
import sys
from itertools import pairwise
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parent.parent
# Comments, texts and characters, then words and signs.
TOKEN = re.compile(
    r"//[^\n]*|/\*.*?\*/"
    r'|b?r(?P<hash>\#*)".*?"(?P=hash)|b?"(?:\\.|[^"\\])*"'
    r"|b?'(?:\\.[^']*|[^'\\])'"
    r"|(?P<code>[A-Za-z_]\w*|::|\S)",
    re.DOTALL,
)


def tokens(text):
    """The words and signs of Rust source without its comments and literals."""
    return [match["code"] for match in TOKEN.finditer(text) if match["code"]]


def tree(words, at, prefix):
    """The paths of a use tree that begins at `at`, each a list of names, and the place behind it."""
    path = list(prefix)
    while at < len(words):
        word = words[at]
        if word == "{":
            paths, at = [], at + 1
            while words[at] != "}":
                more, at = tree(words, at, path)
                paths += more
                if words[at] == ",":
                    at += 1
            return paths, at + 1
        if word == "as":
            at += 2
        elif word == "::":
            at += 1
        elif word == "*" or re.match(r"[A-Za-z_]", word):
            path.append(word)
            at += 1
        else:
            break
    return [path], at


def paths(words, module):
    """Every path from the root, `super` or `self` in a file, without `crate`, and whether a `pub use` exports it. `module` is
    the file's own, empty for the root."""
    inline, at = [], 0  # Names of the inline modules around, None for other braces.
    while at < len(words):
        word = words[at]
        if word == "mod" and words[at + 2 : at + 3] == ["{"]:
            inline.append(words[at + 1])
            at += 3
            continue
        if word == "{":
            inline.append(None)
        elif word == "}" and inline:
            inline.pop()
        imports = word == "use" and words[at + 1] != "<"  # `use<>` of a type names no path.
        if not imports and not (word in ("crate", "super") and words[at + 1 : at + 2] == ["::"] and words[at - 1] != "::"):
            at += 1
            continue
        exported = imports and at > 0 and words[at - 1] in ("pub", ")")
        found, at = tree(words, at + 1 if imports else at, [])
        here = [*module, *(name for name in inline if name)]
        for path in found:
            if path[0] == "crate":
                yield path[1:] or ["*"], exported
            elif path[0] in ("super", "self"):
                up = here
                while path and path[0] in ("super", "self"):
                    up, path = up[: -1 if path[0] == "super" else None], path[1:]
                yield [*up, *path] or ["*"], exported
            elif not here:
                yield path, exported


def rooms(crate):
    """Which rooms of a crate import which, with the file that does."""
    source = crate / "src"
    root = source / "lib.rs" if (source / "lib.rs").exists() else source / "main.rs"
    words = tokens(root.read_text(encoding="utf-8"))
    tops = {name for mod, name, end in zip(words, words[1:], words[2:], strict=False) if mod == "mod" and end == ";"}
    exports = {path[-1]: path[0] for path, exported in paths(words, []) if exported and path[0] in tops}
    uses = {}
    for file in sorted(source.rglob("*.rs")):
        if file == root:
            own = root.stem
            text = re.sub(r"\bpub (?:\( [a-z]+ \) )?use [^;]*;", "", " ".join(words))
            imported = {other for other in tops if re.search(rf"\b{other} ::", text)}
        elif file.parent == source and file.stem == "main":
            continue  # The program over its library.
        else:
            module = list(file.relative_to(source).with_suffix("").parts)
            own = module[0]
            found = paths(tokens(file.read_text(encoding="utf-8")), module)
            imported = {path[0] if path[0] in tops else exports.get(path[0], root.stem) for path, _ in found}
        room = uses.setdefault(own, {})
        for other in sorted(imported - {own}):
            room.setdefault(other, file)
    return uses


def circles(uses):
    """One circle for each set of rooms that lead to each other: lists of rooms, the first again at the end."""
    seen = set()
    for start in sorted(uses):
        ways, found = [[start]], None
        visited = set()
        while ways and not found:
            way = ways.pop(0)
            for other in sorted(uses.get(way[-1], {})):
                if other == start:
                    found = [*way, other]
                    break
                if other not in visited:
                    visited.add(other)
                    ways.append([*way, other])
        if found and not seen & set(found):
            yield found
        seen |= set(found or [])


def table():
    """The crates of ARCHITECTURE.md from top to bottom, with what each uses."""
    text = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
    rows = re.findall(r"^\| `(gaitshift[\w-]*)` \|.*\| ([^|]*) \|$", text, re.MULTILINE)
    names = [name for name, _ in rows]
    allowed = {}
    for name, uses in rows:
        listed = {word if word.startswith("gaitshift") else f"gaitshift{word}" for word in re.findall(r"`([\w-]+)`", uses)}
        allowed[name] = set(names) - listed - {name} if uses.startswith("all but") else listed
    return names, allowed


def dependencies():
    names, allowed = table()
    crates = {tomllib.loads(m.read_text("utf-8"))["package"]["name"]: m for m in sorted(ROOT.glob("crates/*/Cargo.toml"))}
    for name in sorted(set(crates) ^ set(names)):
        yield f"ARCHITECTURE.md: the table of crates and the folder crates/ differ in {name}"
    for name, manifest in crates.items():
        read = tomllib.loads(manifest.read_text("utf-8"))
        used, for_tests = (
            {other for other in read.get(key, {}) if other in crates} for key in ("dependencies", "dev-dependencies")
        )
        where = manifest.relative_to(ROOT)
        for other in sorted(used ^ allowed.get(name, set())):
            has, lacks = (where, "ARCHITECTURE.md's table") if other in used else ("ARCHITECTURE.md's table", where)
            yield f"{name}: {has} names {other}, {lacks} does not"
        for other in sorted((used | for_tests) & set(names)):
            if name in names and names.index(other) <= names.index(name):
                yield f"{where}: uses {other}, which does not stand below it in ARCHITECTURE.md's table"


def tests():
    """Files of tests that nothing runs."""
    for manifest in sorted(ROOT.glob("crates/*/Cargo.toml")):
        folder = manifest.parent / "tests"
        read = tomllib.loads(manifest.read_text("utf-8"))
        run = {test.get("path", f"tests/{test['name']}.rs") for test in read.get("test", [])}
        if "tests/main.rs" in run:
            words = tokens((folder / "main.rs").read_text("utf-8"))
            run |= {f"tests/{name}.rs" for mod, name in pairwise(words) if mod == "mod"}
        for file in sorted(folder.glob("*.rs")):
            if f"tests/{file.name}" not in run:
                yield f"{file.relative_to(ROOT)}: not run; name it in {folder.relative_to(ROOT)}/main.rs"


def main():
    if sys.argv[1:2] == ["--graph"]:
        for own, others in sorted(rooms(ROOT / "crates" / sys.argv[2]).items()):
            print(f"{own}: {', '.join(sorted(others)) or '-'}")
        return 0
    wrong = [*dependencies(), *tests()]
    for crate in sorted(path.parent for path in ROOT.glob("crates/*/Cargo.toml")):
        uses = rooms(crate)
        for circle in circles(uses):
            steps = [f"{uses[a][b].relative_to(ROOT)} imports {b}" for a, b in pairwise(circle)]
            wrong.append(f"{crate.name}: a circle {' → '.join(circle)}: {', '.join(steps)}")
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
