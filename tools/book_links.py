#!/usr/bin/env python3
"""mdBook's preprocessor for docs/ (see book.toml): links that leave the folder become links to the repository, and the
interfaces that tools/book.sh builds beside the book are linked from its first page."""

import json
import re
import sys

REPOSITORY = "https://github.com/gaitshift/gaitshift/blob/main/"
INTERFACES = (
    "- [The Rust libraries](rust/gaitshift_experiment/index.html)\n"
    "- [The Python package](python/gaitshift.html)\n\n"
    "On your machine:\n\n"
)


def rewrite(item):
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if chapter is None:
        return
    text = re.sub(r"\]\(\.\./([^)\s]*)\)", rf"]({REPOSITORY}\1)", chapter["content"])
    chapter["content"] = text.replace("<!-- interfaces -->\n", INTERFACES)
    for sub_item in chapter["sub_items"]:
        rewrite(sub_item)


if sys.argv[1:2] == ["supports"]:
    sys.exit(0)
_context, book = json.load(sys.stdin)
for part in book.get("items", book.get("sections", [])):
    rewrite(part)
json.dump(book, sys.stdout)
