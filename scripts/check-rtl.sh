#!/usr/bin/env bash
# Compares every operation's result of generated hardware with the
# cycle-accurate simulator's, bit for bit and in its cycle, for programs on
# several machines, and prints a table.
#
#   scripts/check-rtl.sh [FILE...]
#
# FILE: a Robotran file, a model (.mbs) or robovec text (.rvir); by default the
# bogie and the serial system of 23 degrees of freedom. Each is placed on 2, 4
# and 8 elements per kind, with memories as in the thesis and split by side,
# and run three times without a reset in between, through the machine's own
# host bus, Avalon-MM and AXI4-Lite, in Verilator; and once in Icarus Verilog,
# which is slower by far, with the images in the memories from configuration
# on.
#
# COUNTS, STYLES, TOOLS and RUNS choose less, WAYS the ways in Icarus Verilog
# (bus, avalon, axi4lite, configured); ROBOVEC names the folder of the
# programs. Exit code 1 when anything differs.
set -euo pipefail

here=$(cd "$(dirname "$0")/.." && pwd)
counts=${COUNTS:-2 4 8}
styles=${STYLES:-thesis side-split}
tools=${TOOLS:-verilator iverilog}
runs=${RUNS:-3}
ways=${WAYS:-configured}
if [ -z "${ROBOVEC:-}" ]; then
    cargo build --quiet --release --manifest-path "$here/Cargo.toml" --bins
    ROBOVEC=$here/target/release
fi
if [ $# -eq 0 ]; then
    set -- "$here/examples/models/bogie.mbs" "$here/examples/models/serial-23.mbs"
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passes=atomise,zero-removal,balance,cse,dce,place

printf '%-24s %-11s %5s %-10s %-10s %7s %10s %10s %9s %6s\n' \
    program memories PEs tool window cycles results words mistakes s
failed=0
for file in "$@"; do
    case $file in
    *.mbs)
        equations=$work/$(basename "$file" .mbs).rvir
        # The equations of the thesis: forces are inputs.
        "$ROBOVEC/robovec" gen "$file" --no-forces --expanded --child-first --leading-signs \
            --function dirdyna >"$equations" 2>"$work/log" || { cat "$work/log"; exit 1; }
        ;;
    *) equations=$file ;;
    esac
    name=$(basename "$file")
    for style in $styles; do
        for count in $counts; do
            machine=$work/machine.toml
            sed "s/^count = .*/count = $count/" "$here/machines/$style.toml" >"$machine"
            "$ROBOVEC/robovec-opt" "$equations" "-passes=$passes" --machine "$machine" \
                -o "$work/placed.rvir" 2>"$work/log" || { cat "$work/log"; exit 1; }
            for tool in $tools; do
                rm -rf "$work/rtl"
                start=$(date +%s%N)
                options=(--runs "$runs")
                [ "$tool" = iverilog ] && options=(--runs 1 --through "$ways")
                "$ROBOVEC/robovec" rtl "$work/placed.rvir" --machine "$machine" \
                    -o "$work/rtl" "${options[@]}" --check "$tool" >"$work/said" 2>"$work/log" ||
                    { failed=1; cat "$work/said" "$work/log"; }
                seconds=$((($(date +%s%N) - start) / 1000000000))
                # PASS name, tool, window: R runs of C cycles, N results …, M mistakes
                sed -nE 's/^(PASS|FAIL) [^,]*, [^,]*, ([^:]*): [0-9]+ runs of ([0-9]+) cycles, ([0-9]+) results[^,]*, ([0-9]+) words[^,]*, [0-9]+ clocks, ([0-9]+) mistakes.*/\2|\3|\4|\5|\6/p' \
                    "$work/said" | while IFS='|' read -r window cycles results words mistakes; do
                    printf '%-24s %-11s %5s %-10s %-10s %7s %10s %10s %9s %6s\n' \
                        "$name" "$style" "$count+$count" "$tool" "$window" "$cycles" "$results" \
                        "$words" "$mistakes" "$seconds"
                done
            done
        done
    done
done
exit $failed
