/* The step of a simulation as MBsysC's library does it around Robotran's
   functions: Newton's method with the whole Jacobian, reduction to independent
   coordinates and Cholesky's method, all with dense matrices (Samin and
   Fisette, Symbolic Modeling of Multibody Systems, 2003, section 3.2.2). */
#include "host.h"
#include <math.h>
#include <stdlib.h>

/* Rounds of Newton's method. */
enum { ROUNDS = 100 };

/* LU factors of a, rows exchanged so that pivots are the largest of their
   columns; 0 when there is none. */
static int factor(double **a, int n, int *order)
{
    for (int k = 1; k <= n; k++) {
        int pivot = k;
        for (int i = k + 1; i <= n; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k]))
                pivot = i;
        order[k] = pivot;
        double *row = a[pivot];
        a[pivot] = a[k];
        a[k] = row;
        if (a[k][k] == 0)
            return 0;
        for (int i = k + 1; i <= n; i++) {
            a[i][k] /= a[k][k];
            for (int j = k + 1; j <= n; j++)
                a[i][j] -= a[i][k] * a[k][j];
        }
    }
    return 1;
}

/* Solves with the factors, in place. */
static void solve(double **a, int n, const int *order, double *b)
{
    for (int k = 1; k <= n; k++) {
        const double kept = b[order[k]];
        b[order[k]] = b[k];
        b[k] = kept;
    }
    for (int i = 2; i <= n; i++)
        for (int j = 1; j < i; j++)
            b[i] -= a[i][j] * b[j];
    for (int i = n; i >= 1; i--) {
        for (int j = i + 1; j <= n; j++)
            b[i] -= a[i][j] * b[j];
        b[i] /= a[i][i];
    }
}

/* Solves M x = b for a positive definite M, both replaced. */
static void cholesky(double **M, int n, double *b)
{
    for (int i = 1; i <= n; i++) {
        for (int j = 1; j <= i; j++) {
            double sum = M[i][j];
            for (int k = 1; k < j; k++)
                sum -= M[i][k] * M[j][k];
            M[i][j] = i == j ? sqrt(sum) : sum / M[j][j];
        }
    }
    for (int i = 1; i <= n; i++) {
        for (int k = 1; k < i; k++)
            b[i] -= M[i][k] * b[k];
        b[i] /= M[i][i];
    }
    for (int i = n; i >= 1; i--) {
        for (int k = i + 1; k <= n; k++)
            b[i] -= M[k][i] * b[k];
        b[i] /= M[i][i];
    }
}

/* Values and Jacobian of all constraints. */
static void constraints(MbsData *s, DenseStep *d)
{
    const int loops = s->Nloopc;
    mbs_cons_hJ(d->h, d->Jac, s, s->tsim);
    if (s->Nuserc > 0)
        user_cons_hJ(d->h + loops, d->Jac + loops, s, s->tsim);
}

/* The entries of the Jacobian that belong to dependent joints. */
static void dependent(const MbsData *s, DenseStep *d)
{
    for (int i = 1; i <= s->nqv; i++)
        for (int j = 1; j <= s->nqv; j++)
            d->Jv[i][j] = d->Jac[s->hu[i]][s->qv[j]];
}

/* Closes the loops; gives the rounds it took, or -1. */
static int close_loops(MbsData *s, DenseStep *d)
{
    const int n = s->nqv;
    for (int round = 0; round <= ROUNDS; round++) {
        double largest = 0;
        constraints(s, d);
        for (int i = 1; i <= n; i++)
            largest = fmax(largest, fabs(d->h[s->hu[i]]));
        dependent(s, d);
        if (!factor(d->Jv, n, d->order))
            return -1;
        if (largest <= s->NRerr)
            return round;
        for (int i = 1; i <= n; i++)
            d->b[i] = d->h[s->hu[i]];
        solve(d->Jv, n, d->order, d->b);
        for (int i = 1; i <= n; i++)
            s->q[s->qv[i]] -= d->b[i];
    }
    return -1;
}

/* Column by column B = -Jv^-1 Juc, and the velocities of dependent joints. */
static void velocities(MbsData *s, DenseStep *d)
{
    const int n = s->nqv, others = s->nqu + s->nqc;
    for (int j = 1; j <= others; j++) {
        for (int i = 1; i <= n; i++)
            d->b[i] = -d->Jac[s->hu[i]][d->uc[j]];
        solve(d->Jv, n, d->order, d->b);
        for (int i = 1; i <= n; i++)
            d->B[i][j] = d->b[i];
    }
    for (int i = 1; i <= n; i++) {
        double sum = 0;
        for (int j = 1; j <= others; j++)
            sum += d->B[i][j] * s->qd[d->uc[j]];
        s->qd[s->qv[i]] = sum;
    }
}

/* M and F = c - Qq, reduced to independent and driven joints. */
static void reduce(MbsData *s, DenseStep *d)
{
    const int n = s->nqv, others = s->nqu + s->nqc;
    for (int i = 1; i <= n; i++) {
        const double *row = d->M[s->qv[i]];
        double *product = d->MvB[i];
        d->b[i] = d->c[s->qv[i]] - s->Qq[s->qv[i]];
        for (int k = 1; k <= n; k++)
            d->b[i] += row[s->qv[k]] * d->bp[k];
        for (int j = 1; j <= others; j++) {
            product[j] = row[d->uc[j]];
            for (int k = 1; k <= n; k++)
                product[j] += row[s->qv[k]] * d->B[k][j];
        }
    }
    for (int i = 1; i <= others; i++) {
        const double *row = d->M[d->uc[i]];
        d->Fr[i] = d->c[d->uc[i]] - s->Qq[d->uc[i]];
        for (int k = 1; k <= n; k++)
            d->Fr[i] += row[s->qv[k]] * d->bp[k] + d->B[k][i] * d->b[k];
        for (int j = 1; j <= others; j++) {
            double sum = row[d->uc[j]];
            for (int k = 1; k <= n; k++)
                sum += row[s->qv[k]] * d->B[k][j] + d->B[k][i] * d->MvB[k][j];
            d->Mr[i][j] = sum;
        }
    }
}

/* Multipliers of the constraints, from the balance of dependent joints, and
   forces of driven joints, from theirs; 0 when there are none. */
static int reactions(MbsData *s, DenseStep *d)
{
    const int n = s->nqv;
    for (int i = 1; i <= n; i++) {
        const double *row = d->M[s->qv[i]];
        double sum = d->c[s->qv[i]] - s->Qq[s->qv[i]];
        for (int j = 1; j <= s->njoint; j++)
            sum += row[j] * s->qdd[j];
        s->lambda[i] = sum;
        for (int j = 1; j <= n; j++)
            d->Jvt[j][i] = d->Jac[s->hu[i]][s->qv[j]];
    }
    if (!factor(d->Jvt, n, d->order))
        return 0;
    solve(d->Jvt, n, d->order, s->lambda);
    for (int i = 1; i <= s->nqc; i++) {
        const int joint = s->qc[i];
        double sum = d->c[joint] - s->Qq[joint];
        for (int j = 1; j <= s->njoint; j++)
            sum += d->M[joint][j] * s->qdd[j];
        for (int k = 1; k <= n; k++)
            sum -= d->Jac[s->hu[k]][joint] * s->lambda[k];
        s->Qc[joint] = sum;
    }
    return 1;
}

int dense_step(MbsData *s, DenseStep *d)
{
    const int n = s->nqv;
    int rounds = 0;
    if (s->nqc > 0)
        user_DrivenJoints(s, s->tsim);
    if (n > 0) {
        rounds = close_loops(s, d);
        if (rounds < 0)
            return -1;
        velocities(s, d);
        mbs_cons_jdqd(d->Jdqd, s, s->tsim);
        if (s->Nuserc > 0)
            user_cons_jdqd(d->Jdqd + s->Nloopc, s, s->tsim);
        for (int i = 1; i <= n; i++)
            d->bp[i] = -d->Jdqd[s->hu[i]];
        solve(d->Jv, n, d->order, d->bp);
    }
    for (int axis = 1; axis <= 3; axis++)
        for (int joint = 1; joint <= s->njoint; joint++)
            s->frc[axis][joint] = s->trq[axis][joint] = 0;
    if (s->Nlink > 0)
        mbs_link(s->frc, s->trq, s->Fl, s->Z, s->Zd, s, s->tsim);
    if (s->Nxfrc > 0)
        mbs_extforces(s->frc, s->trq, s, s->tsim);
    s->Qq = user_JointForces(s, s->tsim);
    mbs_dirdyna(d->M, d->c, s, s->tsim);
    reduce(s, d);
    for (int i = 1; i <= s->nqu; i++) {
        d->b[i] = -d->Fr[i];
        for (int j = 1; j <= s->nqc; j++)
            d->b[i] -= d->Mr[i][s->nqu + j] * s->qdd[s->qc[j]];
    }
    cholesky(d->Mr, s->nqu, d->b);
    for (int i = 1; i <= s->nqu; i++)
        s->qdd[s->qu[i]] = d->b[i];
    for (int i = 1; i <= n; i++) {
        double sum = d->bp[i];
        for (int j = 1; j <= s->nqu + s->nqc; j++)
            sum += d->B[i][j] * s->qdd[d->uc[j]];
        s->qdd[s->qv[i]] = sum;
    }
    if (!reactions(s, d))
        return -1;
    return rounds;
}

/* The independent rows of the constraints at the present state: those whose
   pivots are the largest. */
int dense_rows(MbsData *s, DenseStep *d)
{
    const int n = s->nqv, all = s->Nloopc + s->Nuserc;
    double **a = matrix(all, n);
    int *taken = integers(all);
    constraints(s, d);
    for (int i = 1; i <= all; i++)
        for (int j = 1; j <= n; j++)
            a[i][j] = d->Jac[i][s->qv[j]];
    for (int k = 1; k <= n; k++) {
        int pivot = 0;
        for (int i = 1; i <= all; i++)
            if (!taken[i] && (pivot == 0 || fabs(a[i][k]) > fabs(a[pivot][k])))
                pivot = i;
        if (pivot == 0 || fabs(a[pivot][k]) < 1e-9)
            return 0;
        taken[pivot] = 1;
        s->hu[k] = pivot;
        for (int i = 1; i <= all; i++) {
            if (taken[i])
                continue;
            const double ratio = a[i][k] / a[pivot][k];
            for (int j = k; j <= n; j++)
                a[i][j] -= ratio * a[pivot][j];
        }
    }
    return 1;
}
