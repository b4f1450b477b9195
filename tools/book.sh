#!/usr/bin/env bash
# Builds the documentation as a book into target/book: the pages of docs/, the Rust interface in rust/ and the Python
# interface in python/. Needs mdBook (cargo install mdbook) and a Python in which the package gaitshift is installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
book=$PWD/target/book

mdbook build
cargo doc --workspace --no-deps
rm -rf "$book/rust" "$book/python"
cp -r "${CARGO_TARGET_DIR:-target}/doc" "$book/rust"
mkdir -p "$book/python"
(cd "$book/python" && python3 -m pydoc -w gaitshift gaitshift.env gaitshift.vector gaitshift.sac gaitshift.ray \
    gaitshift._motion gaitshift._training gaitshift._native)
echo "the book is in target/book/index.html" >&2
