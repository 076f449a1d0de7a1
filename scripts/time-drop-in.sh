#!/usr/bin/env bash
# Times Robotran's own C against ours, in one program: first the agreement at
# a random state, then processor time per call, then what compiling took.
#
#   scripts/time-drop-in.sh FILE.c [MODEL.mbs]
#
# FILE is a dirdyna of Robotran's (C with its header beside it, Matlab or
# Python; the latter two are written as C first). With a MODEL ours comes from
# the model, without from the equations of FILE alone. CC, FLAGS, PASSES and
# ROBOVEC can be set.
set -euo pipefail

file=$1
model=${2:-}
robovec=${ROBOVEC:-robovec}
compiler=${CC:-gcc}
read -r -a flags <<<"${FLAGS:--O3 -march=native}"
passes=${PASSES:-\$cpu}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

own=$file
case $file in
    *.c) ;;
    *)
        "$robovec" write "$file" --language c -o "$folder/own" >/dev/null
        own=$(ls "$folder"/own/*.c)
        ;;
esac
source=$file
if [[ -n $model ]]; then
    source=$folder/model.rvir
    "$robovec" gen "$model" --formulation composite -o "$source"
fi
"$robovec" write "$source" --language c --bounded --test-main --rivals robotrans_own \
    --passes "$passes" -o "$folder/ours" >/dev/null
test=$(ls "$folder"/ours/*_test.c)
ours=${test%_test.c}.c

# Files of before 2015 have other names for the same things.
mkdir "$folder/data"
names='typedef struct MbsData MBSdataStruct;'
if grep -q MBSdataStruct "$folder"/ours/*.h; then
    names='typedef struct MBSdataStruct MbsData;'
    printf '#include "MBSdataStructR7.h"\n' >"$folder/data/mbs_data.h"
else
    printf '#include "mbs_data.h"\n' >"$folder/data/MBSdataStructR7.h"
fi
printf '#include "mbs_data.h"\n%s\n' "$names" >"$folder/data/MBSfunR7.h"
: >"$folder/data/mbs_project_interface.h"

seconds() {
    local TIMEFORMAT=%U
    { time "$@" 2>"$folder/messages"; } 2>&1 || {
        cat "$folder/messages" >&2
        return 1
    }
}
cd "$folder"
include=("-I$folder/ours" "-I$folder/data")
here=$OLDPWD
[[ $own = /* ]] || own=$here/$own
own_seconds=$(seconds "$compiler" "${flags[@]}" -w -Dmbs_dirdyna=robotrans_own -Ddirdyna=robotrans_own \
    "${include[@]}" -I"$(dirname "$own")" -c "$own" -o own.o)
our_seconds=$(seconds "$compiler" "${flags[@]}" "${include[@]}" -c "$ours" -o ours.o)
"$compiler" -O1 "${include[@]}" "$test" own.o ours.o -o program -lm
status=0
./program time || status=$?
echo "compile seconds $own_seconds $our_seconds"
exit $status
