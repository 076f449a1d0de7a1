#!/usr/bin/env bash
# Compares robovec's 64-bit evaluation of Robotran C files with the same files
# compiled by `gcc -O0 -ffp-contract=off`, bit for bit, at random states.
#
#   scripts/compare-with-gcc.sh mbs_dirdyna_NAME.c ...
#
# The header of the temporaries (mbs_dirdyna_NAME.h) must lie beside each file.
# User functions are replaced by ones that return numbers of the state. The
# comparison itself is the test `against_gcc`, which says for each file how
# many numbers are equal; exit code 1 when one differs.
set -euo pipefail

if [ $# -lt 1 ]; then
    sed -n '2,10s/^# \{0,1\}//p' "$0"
    exit 2
fi
files=
for file in "$@"; do
    files+=${files:+:}$(realpath "$file")
done
here=$(cd "$(dirname "$0")/.." && pwd)
ROBOVEC_C_FILES=$files cargo test --quiet --manifest-path "$here/Cargo.toml" \
    --workspace --test all against_gcc::files_elsewhere -- --ignored --nocapture
