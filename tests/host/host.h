/* A host of generated equations: memory, and the step with dense matrices. */
#ifndef host_h
#define host_h

#include "mbs_data.h"
#include "mbs_project_interface.h"

/* What the dense step keeps; rows and columns count from 1. */
typedef struct DenseStep
{
    double **M, *c;
    double *h, **Jac, *Jdqd;
    /* The Jacobian of dependent joints and its factors. */
    double **Jv, **Jvt;
    int *order;
    /* Velocities and accelerations of dependent joints: qd_v = B qd_uc,
       qdd_v = B qdd_uc + bp. */
    double **B, *bp;
    double **MvB, **Mr, *Fr, *b;
    /* Independent joints, then driven ones. */
    int *uc;
} DenseStep;

/* Accelerations of all joints for the positions and velocities of independent
   joints; the rounds that closing the loops took, or -1. */
int dense_step(MbsData *s, DenseStep *d);

/* Chooses the independent rows; 0 when the partition has no solution. */
int dense_rows(MbsData *s, DenseStep *d);

double *vector(int length);
int *integers(int length);
double **matrix(int rows, int columns);

#endif
