/* What the peers have in common: how the model and the states come in.

   A program is called as

       program MODEL STATES RESULTS MILLISECONDS

   MODEL is text: gravity, then one line for every joint, in an order in which
   parents come first:

       robovec-tree 1
       gravity 0 0 -9.81
       joints 23
       PARENT KIND  DX DY DZ  MASS  CX CY CZ  IXX IXY IXZ IYY IYZ IZZ

   PARENT counts from 1, 0 is the base. KIND is T1 T2 T3 (slides along) or R1
   R2 R3 (turns about the axis of this number). D is where the joint is
   attached, in the frame behind the parent joint; mass, centre of mass and
   inertia about it belong to what the joint carries, in its own frame.

   STATES holds doubles: the number of states, then q and qd of each. RESULTS
   takes for every state the mass matrix, row by row and in full, and the
   forces c of M qdd + c = Q. */
#ifndef ROBOVEC_PEER_H
#define ROBOVEC_PEER_H

#include "bench.h"

enum { PEER_MOST_JOINTS = 512 };

typedef struct {
    int parent; /* from 0, -1 is the base */
    int revolute, axis;
    double anchor[3], mass, center[3], inertia[6];
} peer_joint;

static int peer_joints, peer_states;
static double peer_gravity[3];
static peer_joint peer_joint_list[PEER_MOST_JOINTS];
static double *peer_q, *peer_qd;

static void peer_read_model(const char *name)
{
    FILE *file = fopen(name, "r");
    if (!file) bench_fail("the model cannot be opened");
    if (fscanf(file, " robovec-tree 1 gravity %lf %lf %lf joints %d", &peer_gravity[0],
               &peer_gravity[1], &peer_gravity[2], &peer_joints) != 4)
        bench_fail("the model does not begin as it should");
    if (peer_joints < 1 || peer_joints > PEER_MOST_JOINTS) bench_fail("too many joints");
    for (int i = 0; i < peer_joints; i++) {
        peer_joint *j = &peer_joint_list[i];
        char kind;
        int axis;
        double *const d = j->anchor, *const c = j->center, *const I = j->inertia;
        if (fscanf(file, " %d %c%d %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf",
                   &j->parent, &kind, &axis, d, d + 1, d + 2, &j->mass, c, c + 1, c + 2, I, I + 1,
                   I + 2, I + 3, I + 4, I + 5) != 16)
            bench_fail("a joint is not as it should be");
        j->parent -= 1;
        j->revolute = kind == 'R';
        j->axis = axis - 1;
    }
    fclose(file);
}

static void peer_read_states(const char *name)
{
    FILE *file = fopen(name, "rb");
    double count;
    if (!file) bench_fail("the states cannot be opened");
    if (fread(&count, sizeof count, 1, file) != 1) bench_fail("there are no states");
    peer_states = (int)count;
    const size_t n = (size_t)peer_joints;
    peer_q = (double *)malloc((size_t)peer_states * n * sizeof(double));
    peer_qd = (double *)malloc((size_t)peer_states * n * sizeof(double));
    for (int s = 0; s < peer_states; s++)
        if (fread(peer_q + (size_t)s * n, sizeof(double), n, file) != n ||
            fread(peer_qd + (size_t)s * n, sizeof(double), n, file) != n)
            bench_fail("states are missing");
    fclose(file);
}

/* What a peer offers: evaluation of a state, and its results. */
static void peer_evaluate(int s);
static void peer_result(double *M, double *c);

static void bench_evaluate(int group)
{
    peer_evaluate(group);
}

static void bench_result(int group, int lane, double *out)
{
    (void)group, (void)lane;
    peer_result(out, out + peer_joints * peer_joints);
}

static int peer_main(int count, char **words)
{
    const size_t n = (size_t)peer_joints;
    return bench_run(peer_states, n * n + n, words[3], count > 4 ? atof(words[4]) : 100.0);
}

static void peer_read(int count, char **words)
{
    if (count < 4) bench_fail("usage: program MODEL STATES RESULTS [MILLISECONDS]");
    peer_read_model(words[1]);
    peer_read_states(words[2]);
}

#endif
