#!/usr/bin/env bash
# Generates the functions of a model and compares them with Robotran's own
# files for it: numbers at random states with the model's parameters, equality
# over the real numbers at random points of a prime field (parameters that are
# zero in the model taken as zero), and operations.
#
#   scripts/compare-with-robotran.sh MODEL.mbs FILE...
#
# FILE: mbs_dirdyna_NAME.c and its like, in any of the three languages. Exit
# code 1 when one differs by more than 1e-13 of the largest element of an
# output array. ROBOVEC names the folder of the programs.
set -euo pipefail

if [ $# -lt 2 ]; then
    sed -n '2,11s/^# \{0,1\}//p' "$0"
    exit 2
fi
programs=${ROBOVEC:-$(dirname "$0")/../target/release}
model=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Operations as the thesis counts them, over all functions of a file.
operations() {
    "$programs/robovec-opt" "$1" --report - -o /dev/null 2>&1 |
        awk '$1 == "operations" { sum += $2 } END { print sum + 0 }'
}

status=0
printf '%-44s %10s %10s %7s  %-9s %s\n' file Robotran robovec ratio proved numbers
for file in "$@"; do
    base=$(basename "$file")
    kind=
    for known in dirdyna invdyna cons_hJ cons_jdqd link extforces sensor gensensor; do
        case $base in mbs_${known}_* | "${known}"_*) kind=$known ;; esac
    done
    if [ -z "$kind" ]; then
        echo "$base: not a function that is generated" >&2
        continue
    fi
    options=()
    if head -100 "$file" | grep -q "All Parameter Symbols included"; then
        options+=(--all-parameters)
    fi
    "$programs/robovec" gen "$model" --function "$kind" "${options[@]}" \
        -o "$work/ours.rvir" 2>/dev/null
    # Generator 6.6 calls the forces of links Flnk.
    if grep -q "Flnk" "$file"; then
        sed -i 's/ Flink\[/ Flnk[/' "$work/ours.rvir"
    fi
    # Generator 6.6 gives no Jacobian of joint frames.
    if [ "$kind" = gensensor ] && ! grep -q 'sens.*J[[(][1-6],\{0,1\}\]\{0,1\}\[\{0,1\}[0-9]*[])] *=' "$file"; then
        sed -i '/ sens\.J\[/d' "$work/ours.rvir"
        "$programs/robovec-opt" "$work/ours.rvir" -passes=dce -o "$work/less.rvir"
        mv "$work/less.rvir" "$work/ours.rvir"
    fi
    # Python's sensors of joint frames are in a function called sensor.
    case $kind-$base in gensensor-*.py) sed -i 's/gensensor_/sensor_/' "$work/ours.rvir" ;; esac
    theirs=$(operations "$file")
    ours=$(operations "$work/ours.rvir")
    proved=no
    "$programs/robovec" check "$file" "$work/ours.rvir" --circle --zeros "$model" >/dev/null 2>&1 && proved=yes
    if numbers=$("$programs/robovec" check "$file" "$work/ours.rvir" --model "$model" 2>&1); then
        numbers=$(echo "$numbers" | sed 's/.*within/within/' | sort -t' ' -k2 -g | tail -1)
    else
        status=1
        numbers=$(echo "$numbers" | grep -v '^$' | head -1)
    fi
    ratio=$(awk -v a="$ours" -v b="$theirs" 'BEGIN { if (b) printf "%.3f", a / b; else print "-" }')
    printf '%-44s %10s %10s %7s  %-9s %s\n' "$base" "$theirs" "$ours" "$ratio" "$proved" "$numbers"
done
exit $status
