/* Laws that suit any model: every joint has a spring and a damper, links too,
   which have no force at the length they begin with, external forces hold
   their points where they began, driven joints swing, and a constraint of the
   user makes a joint follow the sine of an independent one. */
#include "mbs_project_interface.h"
#include <math.h>

void user_DrivenJoints(MbsData *s, double tsim)
{
    for (int i = 1; i <= s->nqc; i++) {
        const int joint = s->qc[i];
        const double speed = 1.5 + 0.25 * i;
        s->q[joint] = 0.03 * sin(speed * tsim);
        s->qd[joint] = 0.03 * speed * cos(speed * tsim);
        s->qdd[joint] = -0.03 * speed * speed * sin(speed * tsim);
    }
}

/* The independent joint of a row. */
static int leader(const MbsData *s, int row)
{
    return s->qu[1 + (row - 1) % s->nqu];
}

void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)
{
    (void)tsim;
    for (int row = 1; row <= s->Nuserc; row++) {
        const int joint = leader(s, row);
        const double value = s->q[s->bound[row]] - 0.3 * sin(s->q[joint]);
        if (!s->is_bound)
            s->h0[row] = value;
        h[row] = value - s->h0[row];
        Jac[row][s->bound[row]] = 1;
        Jac[row][joint] = -0.3 * cos(s->q[joint]);
    }
    s->is_bound = 1;
}

void user_cons_jdqd(double *jdqd, MbsData *s, double tsim)
{
    (void)tsim;
    for (int row = 1; row <= s->Nuserc; row++) {
        const int joint = leader(s, row);
        jdqd[row] = 0.3 * sin(s->q[joint]) * s->qd[joint] * s->qd[joint];
    }
}

double *user_JointForces(MbsData *s, double tsim)
{
    (void)tsim;
    for (int joint = 1; joint <= s->njoint; joint++)
        s->Qq[joint] = -4.0 * s->q[joint] - 0.2 * s->qd[joint] + s->Qx[joint];
    return s->Qq;
}

double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int ilnk)
{
    (void)tsim;
    if (s->Z0[ilnk] == 0)
        s->Z0[ilnk] = Z;
    return 100000.0 * (Z - s->Z0[ilnk]) + 5000.0 * Zd;
}

double *user_ExtForces(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
                       double AxF[4], double OMPxF[4], MbsData *s, double tsim, int ixF)
{
    double *force = s->SWr[ixF];
    double *start = s->P0[ixF];
    (void)RxF, (void)AxF, (void)OMPxF, (void)tsim;
    if (start[0] == 0)
        for (int axis = 0; axis <= 3; axis++)
            start[axis] = axis == 0 ? 1 : PxF[axis];
    for (int axis = 1; axis <= 3; axis++) {
        force[axis] = -30000.0 * (PxF[axis] - start[axis]) - 200.0 * VxF[axis];
        force[3 + axis] = -2.0 * OMxF[axis];
        force[6 + axis] = s->dpt[axis][s->xfidpt[ixF]];
    }
    return force;
}
