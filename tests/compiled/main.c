/* Calls functions of equations at states that depend on names alone, and
   prints every element that a call changed. The test that wrote the list of
   calls evaluates the same functions at the same states. */
#include "stub.h"
#include <setjmp.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int state;

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

typedef struct { const char *name; double **vector; double ***matrix; int rows; } Array;
static MbsData data;
static MbsSensor sensor;
static Array arrays[] = {
    {"q", &data.q, 0, EXTENT - 1}, {"qd", &data.qd, 0, EXTENT - 1},
    {"qdd", &data.qdd, 0, EXTENT - 1}, {"m", &data.m, 0, EXTENT - 1},
    {"g", &data.g, 0, EXTENT - 1}, {"lrod", &data.lrod, 0, EXTENT - 1},
    {"c", &data.c, 0, EXTENT - 1}, {"Qq", &data.Qq, 0, EXTENT - 1},
    {"h", &data.h, 0, EXTENT - 1}, {"Jdqd", &data.Jdqd, 0, EXTENT - 1},
    {"Flink", &data.Flink, 0, EXTENT - 1}, {"Z", &data.Z, 0, EXTENT - 1},
    {"Zd", &data.Zd, 0, EXTENT - 1}, {"dpt", 0, &data.dpt, EXTENT - 1},
    {"l", 0, &data.l, EXTENT - 1}, {"In", 0, &data.In, EXTENT - 1},
    {"frc", 0, &data.frc, EXTENT - 1}, {"trq", 0, &data.trq, EXTENT - 1},
    {"M", 0, &data.M, EXTENT - 1}, {"Jac", 0, &data.Jac, EXTENT - 1},
};
enum { COUNT = sizeof arrays / sizeof arrays[0] };

static void element(const char *name, int i, int j, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf("%s %d %d %016llx\n", name, i, j, (unsigned long long)bits);
}

static void allocate(void) {
    for (int k = 0; k < COUNT; k++) {
        if (arrays[k].vector) { *arrays[k].vector = calloc(EXTENT, 8); continue; }
        double **rows = calloc(EXTENT, sizeof *rows);
        for (int i = 0; i < EXTENT; i++) rows[i] = calloc(EXTENT, 8);
        *arrays[k].matrix = rows;
    }
}

static double *fields[] = {sensor.P, sensor.V, sensor.OM, sensor.A, sensor.OMP};
static const char *field_names[] = {"sens.P", "sens.V", "sens.OM", "sens.A", "sens.OMP"};

/* Sets every element (list 0), or prints those that differ from that. */
static void visit(int list) {
#define VISIT(name, i, j, place) \
    { \
        const double given = number(name, i, j); \
        if (!list) (place) = given; \
        else if (memcmp(&given, &(place), 8)) element(name, i, j, place); \
    }
    for (int k = 0; k < COUNT; k++)
        for (int i = 1; i <= arrays[k].rows; i++) {
            if (arrays[k].vector) { VISIT(arrays[k].name, i, 0, (*arrays[k].vector)[i]) continue; }
            for (int j = 1; j < EXTENT; j++) VISIT(arrays[k].name, i, j, (*arrays[k].matrix)[i][j])
        }
    for (int k = 0; k < 5; k++)
        for (int i = 1; i <= 3; i++) VISIT(field_names[k], i, 0, fields[k][i])
    for (int i = 1; i <= 3; i++)
        for (int j = 1; j <= 3; j++) VISIT("sens.R", i, j, sensor.R[i][j])
    for (int i = 1; i <= 6; i++)
        for (int j = 1; j < EXTENT; j++) VISIT("sens.J", i, j, sensor.J[i][j])
}

/* What a user function is given: by number of the call and of the argument. */
static void argument(int call, int place, int i, int j, double value) {
    char name[32];
    snprintf(name, sizeof name, "call%d.%d", call, place);
    element(name, i, j, value);
}

double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4],
                       double A[4], double OMP[4], MbsData *s, double tsim, int call) {
    static double results[1024][10];
    double *vectors[] = {P, 0, V, OM, A, OMP};
    char name[32];
    (void)s, (void)tsim;
    for (int k = 0; k < 6; k++)
        for (int i = 1; i <= 3; i++) {
            if (vectors[k]) { argument(call, k, i, 0, vectors[k][i]); continue; }
            for (int j = 1; j <= 3; j++) argument(call, k, i, j, R[i][j]);
        }
    snprintf(name, sizeof name, "SWr%d", call);
    for (int i = 1; i <= 9; i++) results[call & 1023][i] = number(name, i, 0);
    return results[call & 1023];
}
double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int call) {
    (void)s, (void)tsim;
    argument(call, 0, 0, 0, Z);
    argument(call, 1, 0, 0, Zd);
    return number("Force", call, 0);
}
double *user_JointForces(MbsData *s, double tsim) {
    static double result[EXTENT];
    (void)s, (void)tsim;
    for (int i = 1; i < EXTENT; i++) result[i] = number("Qq", i, 0);
    return result;
}
void user_DrivenJoints(MbsData *s, double tsim) { (void)s, (void)tsim; }

#include "calls.h"

/* A call that leaves its arrays is named, and the others go on. */
static sigjmp_buf before;
static void lost(int number) { (void)number; siglongjmp(before, 1); }

int main(void) {
    allocate();
    signal(SIGSEGV, lost);
    signal(SIGFPE, lost);
    for (state = 1; state <= STATES; state++)
        for (int k = 0; k < (int)(sizeof calls / sizeof calls[0]); k++) {
            printf("call %d %d\n", state, k);
            visit(0);
            data.tsim = number("tsim", 0, 0);
            if (sigsetjmp(before, 1)) { printf("refused\n"); continue; }
            calls[k].function(&data, &sensor, data.tsim, calls[k].number);
            visit(1);
        }
    return 0;
}
