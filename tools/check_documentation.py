#!/usr/bin/env python3
"""Checks that what the repository says of itself holds together. Needs Python 3.10 and git, nothing else.

    tools/check_documentation.py

- Every relative link and anchor in a Markdown file leads somewhere.
- Every page of docs/ stands in docs/SUMMARY.md, the book's table of contents, once.
- Every crate has a README.md, which its page on a package registry shows, and embeds no file from outside its folder.
- README.md and README.ja.md give the same commands and the same decimal numbers in their tables.
- No file holds a path of the machine it was written on.

Prints what is wrong, one line each, and exits with 1 if there is anything.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
# Home and working folders. `someone` and `ann` are the users of examples and tests.
MACHINE_PATH = re.compile(rb"(?<![\w.:/~-])/(?:home|root|Users|work|tmp|var/folders)/(?!(?:someone|ann)/)[\w.-]+")


def tracked():
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=ROOT, capture_output=True, check=True
    ).stdout
    return sorted(ROOT / name.decode() for name in set(listed.split(b"\0")) if name and (ROOT / name.decode()).is_file())


def without_code(text):
    """The text with fenced and indented code blocks and code spans blanked, so that no link is seen in them."""
    lines, fenced = [], False
    for line in text.split("\n"):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            lines.append("")
        else:
            lines.append("" if fenced or line.startswith("    ") else line)
    return re.sub(r"`[^`\n]*`", "", "\n".join(lines))


def anchors(text):
    """Anchors of the headings, as GitHub and mdBook make them."""
    found = set()
    for heading in re.findall(r"^#+ +(.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), flags=re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        found.add(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return found


def links(pages):
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for target in LINK.findall(without_code(text)):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = page if not path else (page.parent / path)
            where = f"{page.relative_to(ROOT)}: the link {target}"
            if not file.exists():
                yield f"{where} leads nowhere"
            elif anchor and (file.suffix != ".md" or anchor not in anchors(file.read_text(encoding="utf-8"))):
                yield f"{where} names no heading of that page"


def contents():
    docs = ROOT / "docs"
    listed = LINK.findall((docs / "SUMMARY.md").read_text(encoding="utf-8"))
    for page in sorted(docs.glob("*.md")):
        times = listed.count(page.name)
        if page.name != "SUMMARY.md" and times != 1:
            yield f"docs/SUMMARY.md: lists {page.name} {times} times instead of once"


def crates():
    for manifest in sorted(ROOT.glob("crates/*/Cargo.toml")):
        if not (manifest.parent / "README.md").exists():
            yield f"{manifest.parent.relative_to(ROOT)}: has no README.md"
        for source in sorted(manifest.parent.glob("src/**/*.rs")):
            for file in re.findall(r'include(?:_str|_bytes)?!\(\s*"([^"]+)"', source.read_text(encoding="utf-8")):
                if not (source.parent / file).resolve().is_relative_to(manifest.parent):
                    yield f"{source.relative_to(ROOT)}: embeds {file}, which is not in the crate's package"


def commands(text):
    """The lines of the fenced blocks without their comments, and the decimal numbers of each table row."""
    blocks = re.findall(r"```\w*\n(.*?)```", text, flags=re.DOTALL)
    code = [re.sub(r"\s*#.*", "", line) for block in blocks for line in block.split("\n")]
    rows = [sorted(re.findall(r"-?\d+\.\d+", row)) for row in re.findall(r"^\|.*\|$", text, flags=re.MULTILINE)]
    return [line for line in code if line.strip()], rows


def translation():
    english, japanese = (commands((ROOT / name).read_text(encoding="utf-8")) for name in ("README.md", "README.ja.md"))
    for what, ours, theirs in (("command", english[0], japanese[0]), ("table row", english[1], japanese[1])):
        if len(ours) != len(theirs):
            yield f"README.ja.md: {len(theirs)} {what}s, but README.md has {len(ours)}"
            continue
        for mine, other in zip(ours, theirs, strict=True):
            if mine != other:
                yield f"README.ja.md: the {what} {other} differs from README.md's {mine}"


def machine_paths(files):
    for file in files:
        for found in sorted(set(MACHINE_PATH.findall(file.read_bytes()))):
            yield f"{file.relative_to(ROOT)}: holds the path {found.decode()} of a machine"


def main():
    files = tracked()
    pages = [file for file in files if file.suffix == ".md"]
    wrong = [*links(pages), *contents(), *crates(), *translation(), *machine_paths(files)]
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
