#!/usr/bin/env bash
# Runs a simulation of yours with Robotran's equations and with robovec's in
# their place, and compares trajectories and times.
#
#   scripts/try-in-project.sh PROJECT --symbolic DIR --model FILE.mbs
#       --build COMMAND --run COMMAND --result FILE
#       [--configure COMMAND] [--step-configure COMMAND] [--step-run COMMAND]
#       [--functions NAMES] [--tolerance NUMBER] [--times N] [--keep DIR]
#
# PROJECT is copied; nothing in it is changed. Paths of the other options are
# relative to it, commands run in the copy: --configure once (cmake), then for
# each set of equations --build, and --run N times (3). FILE is what the run
# writes: lines of numbers with as many digits as they have, of which lines
# with letters or a # are left out. Sets of equations:
#
#   Robotran  the files in DIR as they are
#   file      each of them written anew by robovec
#   model     each of them generated from the model
#   step      accelred from the model: the whole step; only with
#             --step-configure or --step-run, which switch the project to it.
#             Joints that the project drives must be driven in the model
#
# NAMES are the functions to replace (dirdyna,extforces,sensor,gensensor,
# cons_hJ,cons_jdqd,link,invdyna where DIR has them). Exit code 1 when a number
# differs by more than NUMBER (1e-10) of the largest in its column (at least
# 1), or a set cannot be made or built. ROBOVEC names the folder of robovec.
set -euo pipefail

usage() {
    sed -n '2,30s/^# \{0,1\}//p' "$0"
    exit 2
}
declare -A option=([functions]=dirdyna,extforces,sensor,gensensor,cons_hJ,cons_jdqd,link,invdyna
    [tolerance]=1e-10 [times]=3)
[ $# -gt 0 ] || usage
project=$1
shift
while [ $# -gt 1 ]; do
    case $1 in
    --symbolic | --model | --build | --run | --result | --configure | --step-configure | --step-run | \
        --functions | --tolerance | --times | --keep) option[${1#--}]=$2 ;;
    *) usage ;;
    esac
    shift 2
done
[ $# -eq 0 ] || usage
for needed in symbolic model build run result; do
    [ "${option[$needed]:-}" ] || { echo "--$needed is missing" >&2; usage; }
done
programs=$(cd "${ROBOVEC:-$(dirname "$0")/../target/release}" && pwd)
if [ "${option[keep]:-}" ]; then
    mkdir -p "${option[keep]}"
    work=$(cd "${option[keep]}" && pwd)
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi
copy=$work/project
rm -rf "$copy"
cp -r "$project" "$copy"

# In the copy, with what is printed kept for when it fails.
in_copy() {
    (cd "$copy" && bash -ec "$1") >"$work/log" 2>&1 || {
        tail -20 "$work/log" >&2
        echo "failed: $1" >&2
        return 1
    }
}

# Builds and runs one set of equations; its result and least time are kept.
run_set() {
    local name=$1 command=$2 least= start took
    in_copy "${option[build]}" || return 1
    for _ in $(seq "${option[times]}"); do
        rm -f "$copy/${option[result]}"
        start=$(date +%s.%N)
        in_copy "$command" || return 1
        took=$(awk -v a="$start" -v b="$(date +%s.%N)" 'BEGIN { print b - a }')
        least=$(awk -v a="$took" -v b="${least:-$took}" 'BEGIN { print a < b ? a : b }')
    done
    [ -s "$copy/${option[result]}" ] || { echo "${option[result]} was not written" >&2; return 1; }
    grep -v '[#A-DF-Za-df-z]' "$copy/${option[result]}" >"$work/$name.result"
    echo "$least" >"$work/$name.seconds"
}

# The file of one function in the folder of Robotran's, or nothing.
file_of() {
    find "$work/symbolic" -maxdepth 1 -name "mbs_$1_*.c" | head -1
}

# The files of one set, in a folder; says what was left as it is, and why.
make_set() {
    local set=$1 folder=$work/$1 name file
    rm -rf "$folder"
    mkdir -p "$folder"
    if [ "$set" = step ]; then
        "$programs/robovec" gen "$copy/${option[model]}" --whole-step --generation "$generation" \
            -o "$folder" >"$work/log" 2>&1 || { tail -20 "$work/log" >&2; return 1; }
        return
    fi
    for name in ${option[functions]//,/ }; do
        file=$(file_of "$name")
        [ "$file" ] || continue
        if [ "$set" = model ]; then
            "$programs/robovec" gen "$copy/${option[model]}" --function "$name" \
                $([ "$name" = dirdyna ] && echo "--formulation composite") \
                -o "$work/$name.rvir" >"$work/log" 2>&1 || { refused "$name"; continue; }
            file=$work/$name.rvir
        fi
        "$programs/robovec" gen "$file" --language c --bounded --passes '$cpu' \
            --generation "$generation" -o "$folder" >"$work/log" 2>&1 || refused "$name"
    done
}
put() {
    find "$work/$1" -name '*.[ch]' -exec cp {} "$copy/${option[symbolic]}/" \;
}
refused() {
    echo "$1 stays Robotran's: $(grep -m1 '^error' "$work/log" || head -1 "$work/log")" >&2
}

# Largest difference of two results, relative to the largest number of the
# column (at least 1); or what is wrong.
difference() {
    awk 'NR == FNR { rows = NR; for (i = 1; i <= NF; i++) { first[NR, i] = $i + 0
                 size = $i < 0 ? -$i : $i + 0; if (size > scale[i]) scale[i] = size }; width[NR] = NF; next }
         NF != width[FNR] { wrong = 1 }
         { for (i = 1; i <= NF; i++) { apart = $i - first[FNR, i]; if (apart < 0) apart = -apart
               apart /= scale[i] > 1 ? scale[i] : 1
               if (!(apart <= worst)) worst = apart }; read = FNR }
         END { if (wrong || read != rows) print "other rows"; else printf "%.2g\n", worst }' "$1" "$2"
}

[ "${option[configure]:-}" ] && in_copy "${option[configure]}"
rm -rf "$work/symbolic"
cp -r "$copy/${option[symbolic]}" "$work/symbolic"
generation=8.1
grep -lq MBSdataStruct "$work"/symbolic/*.c && generation=6.6
sets=(Robotran file model)
[ "${option[step-configure]:-}${option[step-run]:-}" ] && sets+=(step)

status=0
printf '%-9s %6s %10s %8s  %s\n' equations files seconds speed "largest difference"
for set in "${sets[@]}"; do
    command=${option[run]}
    rm -rf "$copy/${option[symbolic]:?}"
    cp -r "$work/symbolic" "$copy/${option[symbolic]}"
    files=0
    if [ "$set" != Robotran ]; then
        make_set "$set" || { status=1; continue; }
        put "$set"
        files=$(find "$work/$set" -name '*.c' | wc -l)
    fi
    if [ "$set" = step ]; then
        command=${option[step-run]:-$command}
        if [ "${option[step-configure]:-}" ]; then
            # It may look for the file, and it may fetch Robotran's own again.
            in_copy "${option[step-configure]}" || { status=1; continue; }
            put "$set"
        fi
    fi
    run_set "$set" "$command" || { status=1; continue; }
    apart=$(difference "$work/Robotran.result" "$work/$set.result")
    awk -v set="$set" -v files="$files" -v apart="$apart" -v first="$(cat "$work/Robotran.seconds")" \
        '{ printf "%-9s %6d %10.3f %7.2fx  %s\n", set, files, $1, first / $1, apart }' "$work/$set.seconds"
    awk -v apart="$apart" -v allowed="${option[tolerance]}" \
        'BEGIN { exit !(apart ~ /^[0-9]/ && apart + 0 <= allowed + 0) }' || status=1
done
exit $status
