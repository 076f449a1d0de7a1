#!/usr/bin/env bash
# Installs the wheel of dist/ in a fresh environment and runs the tests of the
# package beside the program that ROBOVEC names (target/release/robovec).
set -euo pipefail
cd "$(dirname "$0")/.."
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
python3 -m venv "$fresh"
"$fresh/bin/pip" install --quiet "$(echo dist/robovec-*.whl)[casadi]"
# From another folder, so that the installed package is found.
tests=$PWD/python/tests
export ROBOVEC=${ROBOVEC:-$PWD/target/release/robovec}
cd "$fresh" && bin/python -m unittest discover -s "$tests"
