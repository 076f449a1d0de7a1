#!/usr/bin/env bash
# Compares robovec's 64-bit evaluation of a Robotran C file with the same file
# compiled by `gcc -O0 -ffp-contract=off`, bit for bit, at random states.
#
#   scripts/compare-with-gcc.sh mbs_dirdyna_NAME.c [STATES]
#
# The header of the temporaries (mbs_dirdyna_NAME.h) must lie beside the file.
# User functions are replaced by ones that return the numbers the states give
# to their results. ROBOVEC may name a built `robovec`.
set -euo pipefail

if [ $# -lt 1 ]; then
    sed -n '2,9s/^# \{0,1\}//p' "$0"
    exit 2
fi
file=$(realpath "$1")
states=${2:-3}
here=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

evaluate() {
    if [ -n "${ROBOVEC:-}" ]; then
        "$ROBOVEC" eval "$1" --states "$2"
    else
        cargo run --quiet --release --manifest-path "$here/Cargo.toml" --bin robovec -- \
            eval "$1" --states "$2"
    fi
}

# The function, without the mbs_ that newer versions put before its name.
function=$(grep -aoE '^(void|int)[[:space:]]+(mbs_)?[A-Za-z0-9_]+[[:space:]]*\(' "$file" |
    grep -oE '[A-Za-z0-9_]+[[:space:]]*\($' | tr -d ' \t(' | head -n 1)
short=${function#mbs_}
case $short in
dirdyna) call="$function(s->M, s->c, s, 0.0)" ;;
invdyna) call="$function(s->Qq, s, 0.0)" ;;
cons_hJ) call="$function(s->h, s->Jac, s, 0.0)" ;;
cons_jdqd) call="$function(s->Jdqd, s, 0.0)" ;;
link) call="$function(s->frc, s->trq, s->Flink, s->Z, s->Zd, s, 0.0)" ;;
link3D | extforces) call="$function(s->frc, s->trq, s, 0.0)" ;;
sensor | gensensor) call="$function(&sens, s, isens)" ;;
accelred | invdynared | dirdyna_odn) call="$function(s, 0.0)" ;;
*)
    echo "$1: no function of a kind this script knows" >&2
    exit 2
    ;;
esac
largest() { grep -aoE "$1" "$file" | grep -oE '[0-9]+' | sort -n | tail -n 1; }
extent=$(largest '\[ *[0-9]+ *\]' || true)
cases=$(largest '^ *case +[0-9]+' || true)
results=$(largest 'SWr[0-9]+' || true)
# The name under which the link's forces are an output.
link_output=$(grep -aqE '\bFlnk *\[' "$file" && echo Flnk || echo Flink)

cat > "$work/stub.h" <<'HEADER'
#ifndef STUB
#define STUB
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <math.h>
typedef struct MbsData {
    double *q, *qd, *qdd, *m, *g, *lrod, *c, *Qq, *h, *Jdqd, *Flink, *Z, *Zd;
    double **dpt, **l, **In, **frc, **trq, **M, **Jac;
    int flag_stop;
} MbsData, MBSdataStruct;
typedef struct MbsSensor {
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4], J[7][EXTENT];
} MbsSensor, MBSsensorStruct;
double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4],
                       double A[4], double OMP[4], MbsData *s, double tsim, int number);
double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number);
double *user_JointForces(MbsData *s, double tsim);
void user_DrivenJoints(MbsData *s, double tsim);
#define user_call_ExtForces user_ExtForces
#define user_call_LinkForces user_LinkForces
#define user_call_JointForces user_JointForces
#define user_call_DrivenJoints user_DrivenJoints
#define mbs_msg(...) ((void)0)
#endif
HEADER
for name in mbs_data.h mbs_sensor.h mbs_project_interface.h mbs_message.h MBSdataStruct.h \
    MBSfun.h MBSdataStructR7.h MBSfunR7.h MBSsensorStruct.h; do
    echo '#include "stub.h"' > "$work/$name"
done

cat > "$work/main.c" <<'MAIN'
#include "stub.h"
#include <stdlib.h>
static FILE *states_file, *changed_file, *final_file;
static int state, isens;
static char label[64];

/* A number in (-1, 1) that depends on the state and the element alone. */
static double number(const char *name, int i, int j) {
    uint64_t x = 1469598103934665603u + (uint64_t)state;
    for (; *name; name++) x = (x ^ (uint64_t)*name) * 1099511628211u;
    x += (uint64_t)i * 0x9e3779b97f4a7c15u + (uint64_t)j * 0xc2b2ae3d27d4eb4fu;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return ((double)(x >> 11) + 0.5) * 0x1p-52 - 1.0;
}

/* The mark of an element that nothing was written to. */
static double mark(void) {
    uint64_t bits = 0x7ff8dead0000beefu;
    double value;
    memcpy(&value, &bits, 8);
    return value;
}
static int same(double a, double b) { return memcmp(&a, &b, 8) == 0; }

typedef struct { const char *name; double **vector; double ***matrix; int rows; int input; } Array;
static MbsData data, *s = &data;
static MbsSensor sens;
static Array arrays[] = {
    {"q", &data.q, 0, EXTENT - 1, 1}, {"qd", &data.qd, 0, EXTENT - 1, 1},
    {"qdd", &data.qdd, 0, EXTENT - 1, 1}, {"m", &data.m, 0, EXTENT - 1, 1},
    {"g", &data.g, 0, 3, 1}, {"lrod", &data.lrod, 0, EXTENT - 1, 1},
    {"dpt", 0, &data.dpt, 3, 1}, {"l", 0, &data.l, 3, 1}, {"In", 0, &data.In, 9, 1},
    {"frc", 0, &data.frc, 3, 1}, {"trq", 0, &data.trq, 3, 1},
    {"c", &data.c, 0, EXTENT - 1, 0}, {"Qq", &data.Qq, 0, EXTENT - 1, 0},
    {"h", &data.h, 0, EXTENT - 1, 0}, {"Jdqd", &data.Jdqd, 0, EXTENT - 1, 0},
    {LINK_OUTPUT, &data.Flink, 0, EXTENT - 1, 0}, {"Z", &data.Z, 0, EXTENT - 1, 0},
    {"Zd", &data.Zd, 0, EXTENT - 1, 0}, {"M", 0, &data.M, EXTENT - 1, 0},
    {"Jac", 0, &data.Jac, EXTENT - 1, 0},
};
enum { COUNT = sizeof arrays / sizeof arrays[0] };

static void element(FILE *file, const char *name, int i, int j, double value) {
    if (file != states_file) fprintf(file, "state %d %s ", state, label);
    if (j) fprintf(file, "%s[%d,%d] %a\n", name, i, j, value);
    else if (i) fprintf(file, "%s[%d] %a\n", name, i, value);
    else fprintf(file, "%s %a\n", name, value);
}

static void allocate(void) {
    for (int k = 0; k < COUNT; k++) {
        if (arrays[k].vector) { *arrays[k].vector = calloc(EXTENT, 8); continue; }
        double **rows = calloc((size_t)arrays[k].rows + 1, sizeof *rows);
        for (int i = 0; i <= arrays[k].rows; i++) rows[i] = calloc(EXTENT, 8);
        *arrays[k].matrix = rows;
    }
}

static void fill(int list) {
    for (int k = 0; k < COUNT; k++)
        for (int i = 1; i <= arrays[k].rows; i++)
            for (int j = 1; j < (arrays[k].matrix ? EXTENT : 2); j++) {
                int column = arrays[k].matrix ? j : 0;
                double *place = column ? &(*arrays[k].matrix)[i][j] : &(*arrays[k].vector)[i];
                *place = arrays[k].input ? number(arrays[k].name, i, column) : mark();
                if (list && arrays[k].input) element(states_file, arrays[k].name, i, column, *place);
            }
}

static void list_results(int count) {
    char name[32];
    for (int i = 1; i < EXTENT; i++) element(states_file, "Qq", i, 0, number("Qq", i, 0));
    for (int k = 1; k <= count; k++) {
        snprintf(name, sizeof name, "SWr%d", k);
        for (int i = 1; i <= 9; i++) element(states_file, name, i, 0, number(name, i, 0));
    }
#define RESULT(name, k) element(states_file, name, 0, 0, number("Flink", k, 0));
#include "results.h"
}

static void vector(const char *name, int number_of_call, double *values) {
    char full[32];
    snprintf(full, sizeof full, "%s%d", name, number_of_call);
    for (int i = 1; i <= 3; i++) element(final_file, full, i, 0, values[i]);
}

double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4],
                       double A[4], double OMP[4], MbsData *unused, double tsim, int k) {
    char name[32];
    double *result = calloc(10, 8);
    vector("PxF", k, P);
    vector("VxF", k, V);
    vector("OMxF", k, OM);
    vector("AxF", k, A);
    vector("OMPxF", k, OMP);
    snprintf(name, sizeof name, "RxF%d", k);
    for (int i = 1; i <= 3; i++)
        for (int j = 1; j <= 3; j++) element(final_file, name, i, j, R[i][j]);
    snprintf(name, sizeof name, "SWr%d", k);
    for (int i = 1; i <= 9; i++) result[i] = number(name, i, 0);
    (void)unused, (void)tsim;
    return result;
}
double user_LinkForces(double Z, double Zd, MbsData *unused, double tsim, int k) {
    char name[32];
    snprintf(name, sizeof name, "Z%d", k);
    element(changed_file, name, 0, 0, Z);
    snprintf(name, sizeof name, "Zd%d", k);
    element(changed_file, name, 0, 0, Zd);
    (void)unused, (void)tsim;
    return number("Flink", k, 0);
}
double *user_JointForces(MbsData *unused, double tsim) {
    static double result[EXTENT];
    for (int i = 1; i < EXTENT; i++) result[i] = number("Qq", i, 0);
    (void)unused, (void)tsim;
    return result;
}
void user_DrivenJoints(MbsData *unused, double tsim) { (void)unused, (void)tsim; }

static void written(const char *name, int i, int j, double before, double after) {
    element(final_file, name, i, j, after);
    if (!same(before, after)) element(changed_file, name, i, j, after);
}

static void compare_arrays(void) {
    for (int k = 0; k < COUNT; k++)
        for (int i = 1; i <= arrays[k].rows; i++)
            for (int j = 1; j < (arrays[k].matrix ? EXTENT : 2); j++) {
                int column = arrays[k].matrix ? j : 0;
                double after = column ? (*arrays[k].matrix)[i][j] : (*arrays[k].vector)[i];
                double before = arrays[k].input ? number(arrays[k].name, i, column) : mark();
                written(arrays[k].name, i, column, before, after);
            }
}

static void mark_sensor(void) {
    double *values = (double *)&sens;
    for (size_t k = 0; k < sizeof sens / 8; k++) values[k] = mark();
}

static void compare_sensor(void) {
    double *vectors[] = {sens.P, sens.V, sens.OM, sens.A, sens.OMP};
    const char *names[] = {"sens.P", "sens.V", "sens.OM", "sens.A", "sens.OMP"};
    for (int k = 0; k < 5; k++)
        for (int i = 1; i <= 3; i++) written(names[k], i, 0, mark(), vectors[k][i]);
    for (int i = 1; i <= 3; i++)
        for (int j = 1; j <= 3; j++) written("sens.R", i, j, mark(), sens.R[i][j]);
    for (int i = 1; i <= 6; i++)
        for (int j = 1; j < EXTENT; j++) written("sens.J", i, j, mark(), sens.J[i][j]);
}

#include FILE_UNDER_TEST
#undef q
#undef qd
#undef qdd

int main(int count, char **arguments) {
    states_file = fopen(arguments[2], "w");
    changed_file = fopen(arguments[3], "w");
    final_file = fopen(arguments[4], "w");
    (void)count;
    allocate();
    for (state = 1; state <= atoi(arguments[1]); state++) {
        fprintf(states_file, "state\n");
        fill(1);
        list_results(RESULTS);
        for (isens = 1; isens <= (CASES ? CASES : 1); isens++) {
            if (CASES) snprintf(label, sizeof label, "%s_%d", SHORT_NAME, isens);
            else snprintf(label, sizeof label, "%s", SHORT_NAME);
            fill(0);
            mark_sensor();
            CALL;
            compare_arrays();
            compare_sensor();
        }
    }
    fclose(states_file), fclose(changed_file), fclose(final_file);
    return 0;
}
MAIN

# Which name takes the result of which link: `Flink2 = user_LinkForces(...,2);`.
grep -aoE '[A-Za-z0-9_]+ *= *user_(call_)?LinkForces\([^)]*, *[0-9]+ *\)' "$file" |
    sed -E 's/^([A-Za-z0-9_]+).*, *([0-9]+) *\)$/RESULT("\1", \2)/' > "$work/results.h" || true

gcc -O0 -ffp-contract=off -w -I"$work" -I"$(dirname "$file")" \
    -DEXTENT=$((${extent:-3} > 9 ? extent + 1 : 10)) -DCASES="${cases:-0}" -DRESULTS="${results:-0}" \
    -DLINK_OUTPUT="\"$link_output\"" -DSHORT_NAME="\"$short\"" -DCALL="$call" \
    -DFILE_UNDER_TEST="\"$file\"" -o "$work/compiled" "$work/main.c" -lm
"$work/compiled" "$states" "$work/states" "$work/changed" "$work/final"
evaluate "$file" "$work/states" > "$work/ours"

export LC_ALL=C
sort -u "$work/ours" > "$work/ours.sorted"
sort -u "$work/changed" > "$work/changed.sorted"
sort -u "$work/changed" "$work/final" > "$work/all.sorted"
comm -13 "$work/all.sorted" "$work/ours.sorted" > "$work/wrong"
comm -23 "$work/changed.sorted" "$work/ours.sorted" > "$work/absent"
if [ -s "$work/wrong" ] || [ -s "$work/absent" ]; then
    echo "$1: differs from gcc; robovec's numbers that gcc does not have:" >&2
    head -n 10 "$work/wrong" >&2
    echo "gcc's numbers that robovec does not have:" >&2
    head -n 10 "$work/absent" >&2
    exit 1
fi
echo "$1: $(wc -l < "$work/ours.sorted") output values at $states states equal gcc's bit for bit"
