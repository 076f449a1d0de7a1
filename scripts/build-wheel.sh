#!/usr/bin/env bash
# Builds the wheel of the Python package into dist/, with maturin from an
# environment of its own; the profile can be given (dev compiles faster).
set -euo pipefail
cd "$(dirname "$0")/.."
tools=target/python-tools
[ -x "$tools/bin/maturin" ] || {
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet 'maturin>=1.9,<2'
}
scripts/third-party-licences robovec-python >python/THIRD-PARTY.txt
rm -f dist/robovec-*.whl
"$tools/bin/maturin" build --profile "${1:-release}" --quiet --manifest-path python/Cargo.toml --out dist
ls dist/*.whl
