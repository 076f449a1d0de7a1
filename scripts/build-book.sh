#!/usr/bin/env bash
# Builds the manual in docs/ as a folder of HTML, dist/book, with mdBook.
# Nothing is installed; the pages need no network.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v mdbook >/dev/null || {
    echo "mdbook is missing: cargo install mdbook --version 0.5.4 --locked" >&2
    exit 1
}
rm -rf dist/book
mdbook build
echo dist/book/index.html
