#!/bin/sh
# Builds the bench in plain Verilog with Icarus Verilog and runs it through
# every window, or through those that are named:
#
#   bus avalon axi4lite   a machine that holds nothing at first
#   configured            one that holds the images, through its own host bus
#
# RTL names the folder of the hardware, if it is not ../rtl. The exit code is
# 0 only if all of them pass.
cd "$(dirname "$0")" || exit 2
rtl=${RTL:-../rtl}
build() {
    out=$1
    shift
    # shellcheck disable=SC2046
    iverilog -g2005 -o "$out" -s robovec_bench "$@" robovec_bench.v robovec_bench_top.v \
        robovec_avalon.v robovec_axi4lite.v $(sed "s|^|$rtl/|" "$rtl/files.f")
}
built=
result=0
for window in ${*:-bus avalon axi4lite configured}; do
    # -N: a failed bench stops, and then the exit code is not 0.
    if [ "$window" = configured ]; then
        build configured.vvp -DROBOVEC_CONFIGURED || exit 2
        vvp -N configured.vvp || result=1
    else
        [ -n "$built" ] || build robovec_bench.vvp || exit 2
        built=yes
        vvp -N robovec_bench.vvp "+$window" || result=1
    fi
done
exit $result
