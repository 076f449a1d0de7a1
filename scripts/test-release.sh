#!/usr/bin/env bash
# Tests what scripts/release.sh made, as a user has it: unpacked outside the
# repository, in an empty environment.
set -euo pipefail
cd "$(dirname "$0")/.."
dist=$PWD/dist
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
(cd "$dist" && sha256sum --quiet --check SHA256SUMS)
tar -C "$fresh" -xzf "$dist"/robovec-*.tar.gz
cd "$fresh"
mv robovec-* robovec
# A command in an empty environment.
bare() { env -i PATH="$fresh/robovec/bin:/usr/bin:/bin" HOME="$fresh" LC_ALL=C.UTF-8 "$@"; }
doc=robovec/share/doc/robovec

bare robovec --version
bare robovec optimise --quiet $doc/examples/suspension/mbs_dirdyna_suspension.m -o best >optimised.txt
bare robovec check $doc/examples/suspension/mbs_dirdyna_suspension.m best/program.rvir --class real-trig
bare robovec-opt $doc/examples/models/bogie.mbs '-passes=$shorten' --check-each -o bogie.rvir
if command -v man >/dev/null; then
    for page in robovec/share/man/man1/*.1; do
        warnings=$(bare man --warnings -E UTF-8 -l "$page" 2>&1 >/dev/null)
        [ -z "$warnings" ] || { echo "$page: $warnings" && exit 1; }
    done
    echo "$(ls robovec/share/man/man1 | wc -l) manual pages render"
else
    echo "SKIPPED: manual pages; man is needed"
fi
# What a tab after these words offers.
completed() {
    bare bash --norc -c '
        source robovec/share/bash-completion/completions/$1
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMP_TYPE=9
        function=$(complete -p $1 | sed "s/.*-F \([^ ]*\) .*/\1/")
        "$function" "$1" "${@: -1}" "${@: -2:1}" && echo "${COMPREPLY[@]}"' bash "$@"
}
completed robovec opt | grep -q optimise
completed robovec-opt --list-m | grep -q list-machines
grep -q '^#compdef robovec' robovec/share/zsh/site-functions/_robovec
echo "completions offer commands and options"
for file in LICENSE-MIT LICENSE-APACHE THIRD-PARTY.txt CHANGELOG.md docs/optimise.md; do [ -s $doc/$file ]; done

python3 -m venv python
python/bin/pip install --quiet "$dist"/robovec-*.whl twine
python/bin/twine check --strict "$dist"/robovec-*.whl
cat >jacobian.py <<'PYTHON'
import sys
import numpy as np
import robovec

arm = robovec.load(sys.argv[1], function="invdyna_d", numbers=True, forces=False)
joints = arm.inputs["q"][0]
state = dict(q=np.full(joints, 0.3), qd=np.zeros(joints), qdd=np.zeros(joints))
jacobian = arm(**state)["Qq_q"]
step, slope = 1e-6, np.zeros(joints)
slope[1] = step
forces = lambda q: robovec.load(sys.argv[1], function="invdyna", numbers=True, forces=False)(**{**state, "q": q})["Qq"]
difference = (forces(state["q"] + slope) - forces(state["q"] - slope)) / (2 * step)
assert np.allclose(jacobian[:, 1], difference, atol=1e-6), (jacobian[:, 1], difference)
print(f"the Jacobian of a URDF, {jacobian.shape}, agrees with differences")
PYTHON
bare python/bin/python jacobian.py "$doc/examples/robots/arm.urdf"
