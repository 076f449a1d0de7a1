/* Lets the host call functions with the names of generator 6.6. */
#include "MBSfunR7.h"
#include <math.h>
#include <stdio.h>

/* More than any model of the tests has. */
enum { JOINTS = 200 };

void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim)
{
    dirdyna(M, c, s, tsim);
}

void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)
{
    cons_hJ(h, Jac, s, tsim);
}

void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim)
{
    cons_jdqd(Jdqd, s, tsim);
}

void mbs_link(double **frc, double **trq, double *Flink, double *Z, double *Zd, MbsData *s, double tsim)
{
    link(frc, trq, Flink, Z, Zd, s, tsim);
}

void mbs_extforces(double **frc, double **trq, MbsData *s, double tsim)
{
    extforces(frc, trq, s, tsim);
}

int mbs_accelred(MbsData *s, double tsim)
{
    double qddu[JOINTS + 1];
    const int rounds = accelred(qddu, s, tsim);
    for (int i = 1; rounds >= 0 && i <= s->nqu; i++) {
        if (qddu[i] != s->qdd[s->qu[i]]) {
            fprintf(stderr, "accelred fills other numbers than it computes\n");
            return -1;
        }
    }
    return rounds;
}
