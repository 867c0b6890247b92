#!/usr/bin/env bash
# Renders README.md, docs/ and the crates' READMEs as a book in target/book/html, with mdBook:
#
#   cargo install mdbook --locked && docs/book/build.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
command -v mdbook > /dev/null || { echo "mdbook is not installed: cargo install mdbook --locked" >&2; exit 77; }
book=target/book
rm -rf $book
mkdir -p $book/src
# With the paths of the repository, so that links hold.
find . -path ./target -prune -o -path '*/.*' -prune -o -path ./docs/book -prune -o \
  \( -name '*.md' -o -path './docs/*.png' -o -path './docs/*.svg' -o -path './docs/*.webp' \) -type f -print0 | xargs -0 cp --parents -t $book/src
cp docs/book/SUMMARY.md $book/src
cp docs/book/book.toml $book
mdbook build $book --dest-dir "$PWD/$book/html"
