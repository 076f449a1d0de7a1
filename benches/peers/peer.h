/* What the peers have in common: how the task, the model and the states come in.

   A program is called as

       program TASK MODEL STATES RESULTS MILLISECONDS

   TASK is what it computes:

       dirdyna   the mass matrix, row by row and in full, and the forces c of
                 M qdd + c = Q
       invdyna   the forces Q, of accelerations
       accelred  the accelerations qdd, of forces
       invdyna_d the derivatives of the forces Q by q and by qd, two matrices
       dirdyna_d the derivatives of the accelerations qdd by q, by qd and by the
                 forces, three matrices

   MODEL is text: gravity, then one line for every joint, in an order in which
   parents come first:

       robovec-tree 2
       gravity 0 0 -9.81
       joints 23
       PARENT KIND SIGN  DX DY DZ  T11 T12 T13 T21 T22 T23 T31 T32 T33
           MASS  CX CY CZ  IXX IXY IXZ IYY IYZ IZZ

   PARENT counts from 1, 0 is the base. KIND is T1 T2 T3 (slides along) or R1
   R2 R3 (turns about the axis of this number). SIGN is -1 where the joint moves
   against its axis: here its numbers change their sign on the way in and out, so
   that no peer sees it. D is where the joint is attached, in the frame behind the
   parent joint; T takes components in the joint's frame at rest to those in that
   frame; mass, centre of mass and inertia about it belong to what the joint
   carries, in its own frame.

   STATES holds doubles: the number of states, 1 with loads or else 0, then of
   each state q, qd, what is given (qdd for invdyna and invdyna_d, Q for accelred
   and dirdyna_d, nothing for dirdyna), and with loads six numbers for every joint: force and torque
   on what it carries, at the centre of mass and in its own frame. RESULTS
   takes the results of every state.

   A program that computes BENCH_LANES states at once finds the numbers of a
   group of so many together: all lanes of the first number, of the second ... */
#ifndef ROBOVEC_PEER_H
#define ROBOVEC_PEER_H

#include "bench.h"

enum { PEER_MOST_JOINTS = 512 };

typedef struct {
    int parent; /* from 0, -1 is the base */
    int revolute, axis;
    int turned; /* turn is not the identity */
    double sign, anchor[3], turn[9], mass, center[3], inertia[6];
} peer_joint;

typedef enum {
    PEER_DIRDYNA,
    PEER_INVDYNA,
    PEER_ACCELRED,
    PEER_INVDYNA_D,
    PEER_DIRDYNA_D
} peer_task;

static peer_task peer_wanted;
static int peer_joints, peer_states, peer_has_loads;
static double peer_gravity[3];
static peer_joint peer_joint_list[PEER_MOST_JOINTS];
static double *peer_q, *peer_qd, *peer_given, *peer_loads;

static void peer_read_list(FILE *file, double *list, int count)
{
    for (int k = 0; k < count; k++)
        if (fscanf(file, " %lf", &list[k]) != 1) bench_fail("a joint is not as it should be");
}

static void peer_read_model(const char *name)
{
    FILE *file = fopen(name, "r");
    if (!file) bench_fail("the model cannot be opened");
    if (fscanf(file, " robovec-tree 2 gravity %lf %lf %lf joints %d", &peer_gravity[0],
               &peer_gravity[1], &peer_gravity[2], &peer_joints) != 4)
        bench_fail("the model does not begin as it should");
    if (peer_joints < 1 || peer_joints > PEER_MOST_JOINTS) bench_fail("too many joints");
    for (int i = 0; i < peer_joints; i++) {
        peer_joint *j = &peer_joint_list[i];
        char kind;
        int axis;
        if (fscanf(file, " %d %c%d %lf", &j->parent, &kind, &axis, &j->sign) != 4)
            bench_fail("a joint is not as it should be");
        peer_read_list(file, j->anchor, 3);
        peer_read_list(file, j->turn, 9);
        peer_read_list(file, &j->mass, 1);
        peer_read_list(file, j->center, 3);
        peer_read_list(file, j->inertia, 6);
        j->turned = 0;
        for (int k = 0; k < 9; k++) j->turned |= j->turn[k] != (k % 4 ? 0.0 : 1.0);
        j->parent -= 1;
        j->revolute = kind == 'R';
        j->axis = axis - 1;
    }
    fclose(file);
}

/* Storage for so many numbers of every state, as wide as a group needs. */
static double *peer_storage(size_t numbers)
{
    const size_t align = sizeof(double) * BENCH_LANES;
    const size_t size = (size_t)peer_states * numbers * sizeof(double) + align;
    double *storage = (double *)aligned_alloc(align, size / align * align);
    if (!storage) bench_fail("there is no memory for the states");
    return storage;
}

/* The numbers of a group in such storage. */
static const double *peer_group(const double *storage, int group, size_t numbers)
{
    return storage + (size_t)group * numbers * BENCH_LANES;
}

static void peer_read_numbers(FILE *file, int s, double *storage, size_t numbers)
{
    double *to = storage + (size_t)(s / BENCH_LANES) * numbers * BENCH_LANES + s % BENCH_LANES;
    for (size_t i = 0; i < numbers; i++)
        if (fread(to + i * BENCH_LANES, sizeof *to, 1, file) != 1) bench_fail("states are missing");
}

/* One number for every joint, along its axis. */
static void peer_read_along(FILE *file, int s, double *storage, size_t joints)
{
    double *to = storage + (size_t)(s / BENCH_LANES) * joints * BENCH_LANES + s % BENCH_LANES;
    peer_read_numbers(file, s, storage, joints);
    for (size_t i = 0; i < joints; i++) to[i * BENCH_LANES] *= peer_joint_list[i].sign;
}

static void peer_read_states(const char *name)
{
    FILE *file = fopen(name, "rb");
    double head[2];
    if (!file) bench_fail("the states cannot be opened");
    if (fread(head, sizeof *head, 2, file) != 2) bench_fail("there are no states");
    peer_states = (int)head[0];
    peer_has_loads = head[1] != 0.0;
    const size_t n = (size_t)peer_joints, given = peer_wanted == PEER_DIRDYNA ? 0 : n;
    const size_t loads = peer_has_loads ? 6 * n : 0;
    peer_q = peer_storage(n);
    peer_qd = peer_storage(n);
    peer_given = peer_storage(given);
    peer_loads = peer_storage(loads);
    for (int s = 0; s < peer_states; s++) {
        peer_read_along(file, s, peer_q, n);
        peer_read_along(file, s, peer_qd, n);
        peer_read_along(file, s, peer_given, given);
        peer_read_numbers(file, s, peer_loads, loads);
    }
    fclose(file);
}

/* Matrices of joints among the results, in full, which come before the vector. */
static int peer_matrices(void)
{
    switch (peer_wanted) {
    case PEER_DIRDYNA: return 1;
    case PEER_INVDYNA_D: return 2;
    case PEER_DIRDYNA_D: return 3;
    default: return 0;
    }
}

/* Numbers of joints behind them. */
static int peer_vector(void)
{
    return peer_wanted < PEER_INVDYNA_D ? peer_joints : 0;
}

/* What a peer offers: evaluation of a group of states, and the results of one
   of them after that, in the order of RESULTS. */
static void peer_evaluate(int group);
static void peer_result(int lane, double *out);

static void bench_evaluate(int group)
{
    peer_evaluate(group);
}

static void bench_result(int group, int lane, double *out)
{
    const int n = peer_joints, matrix = peer_matrices() * n * n;
    (void)group;
    peer_result(lane, out);
    for (int i = 0; i < matrix; i++)
        out[i] *= peer_joint_list[i / n % n].sign * peer_joint_list[i % n].sign;
    for (int i = 0; i < peer_vector(); i++) out[matrix + i] *= peer_joint_list[i].sign;
}

static int peer_main(int count, char **words)
{
    const size_t n = (size_t)peer_joints;
    const size_t results = (size_t)peer_matrices() * n * n + (size_t)peer_vector();
    return bench_run(peer_states, results, words[4], count > 5 ? atof(words[5]) : 100.0);
}

static peer_task peer_task_named(const char *name)
{
    if (!strcmp(name, "invdyna")) return PEER_INVDYNA;
    if (!strcmp(name, "accelred")) return PEER_ACCELRED;
    if (!strcmp(name, "invdyna_d")) return PEER_INVDYNA_D;
    if (!strcmp(name, "dirdyna_d")) return PEER_DIRDYNA_D;
    if (strcmp(name, "dirdyna")) bench_fail("no such task");
    return PEER_DIRDYNA;
}

static void peer_read(int count, char **words)
{
    if (count < 5) bench_fail("usage: program TASK MODEL STATES RESULTS [MILLISECONDS]");
    peer_wanted = peer_task_named(words[1]);
    peer_read_model(words[2]);
    peer_read_states(words[3]);
}

#endif
