/* Integrates a model twice, with the dense step around Robotran-style
   functions and with mbs_accelred, and tells how far the two are apart and how
   long they took.

       host DATA SECONDS STEPS

   DATA holds numbers in the order in which they are read here. Fourth order
   Runge-Kutta with a fixed step. Prints: the largest difference of a position,
   in parts of the largest position; the largest position; seconds per step of
   the dense way; of the other; the most rounds that closing took in each; the
   difference of multipliers and forces of driven joints in the first step; how
   well forces of actuators do what they are for, where ACTUATORS is defined. */
#define _POSIX_C_SOURCE 199309L
#include "host.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void *cleared(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "no memory\n");
        exit(2);
    }
    return memory;
}

double *vector(int length)
{
    return cleared((size_t)length + 1, sizeof(double));
}

int *integers(int length)
{
    return cleared((size_t)length + 1, sizeof(int));
}

double **matrix(int rows, int columns)
{
    double **all = cleared((size_t)rows + 1, sizeof(double *));
    for (int row = 0; row <= rows; row++)
        all[row] = vector(columns);
    return all;
}

static int whole(FILE *file)
{
    int number;
    if (fscanf(file, "%d", &number) != 1) {
        fprintf(stderr, "the data end early\n");
        exit(2);
    }
    return number;
}

static double real(FILE *file)
{
    double number;
    if (fscanf(file, "%lf", &number) != 1) {
        fprintf(stderr, "the data end early\n");
        exit(2);
    }
    return number;
}

static double *reals(FILE *file, int length)
{
    double *numbers = vector(length);
    for (int i = 1; i <= length; i++)
        numbers[i] = real(file);
    return numbers;
}

static int *wholes(FILE *file, int *length)
{
    *length = whole(file);
    int *numbers = integers(*length);
    for (int i = 1; i <= *length; i++)
        numbers[i] = whole(file);
    return numbers;
}

/* Reads a model. */
static MbsData *load(const char *path)
{
    FILE *file = fopen(path, "r");
    MbsData *s = cleared(1, sizeof(MbsData));
    if (file == NULL) {
        fprintf(stderr, "cannot open %s\n", path);
        exit(2);
    }
    s->njoint = whole(file);
    s->npt = whole(file);
    s->qu = wholes(file, &s->nqu);
    s->qc = wholes(file, &s->nqc);
    s->qv = wholes(file, &s->nqv);
    s->bound = wholes(file, &s->Nuserc);
    s->Nloopc = whole(file);
    s->nhu = s->nqv;
    s->hu = integers(s->nhu);
    s->q = reals(file, s->njoint);
    s->qd = reals(file, s->njoint);
    s->qdd = vector(s->njoint);
    for (int axis = 1; axis <= 3; axis++)
        s->dpt[axis] = reals(file, s->npt);
    for (int axis = 1; axis <= 3; axis++)
        s->l[axis] = reals(file, s->njoint);
    s->m = reals(file, s->njoint);
    for (int entry = 1; entry <= 9; entry++)
        s->In[entry] = reals(file, s->njoint);
    for (int axis = 1; axis <= 3; axis++)
        s->g[axis] = real(file);
    int rods = whole(file);
    s->lrod = reals(file, rods);
    s->Nlink = whole(file);
    s->xfidpt = wholes(file, &s->Nxfrc);
    fclose(file);
    for (int axis = 1; axis <= 3; axis++) {
        s->frc[axis] = vector(s->njoint);
        s->trq[axis] = vector(s->njoint);
    }
    s->Qq = vector(s->njoint);
    s->Qx = vector(s->njoint);
    s->Qc = vector(s->njoint);
    s->Qa = vector(s->njoint);
    s->lambda = vector(s->nhu);
    s->h0 = vector(s->Nuserc);
    s->Fl = vector(s->Nlink);
    s->Z = vector(s->Nlink);
    s->Zd = vector(s->Nlink);
    s->Z0 = vector(s->Nlink);
    s->P0 = matrix(s->Nxfrc, 3);
    s->SWr = matrix(s->Nxfrc, 9);
    s->NRerr = 1e-14;
    return s;
}

static DenseStep *dense(const MbsData *s)
{
    const int n = s->njoint, rows = s->Nloopc + s->Nuserc, most = n > rows ? n : rows;
    DenseStep *d = cleared(1, sizeof(DenseStep));
    d->M = matrix(n, n);
    d->c = vector(n);
    d->h = vector(rows);
    d->Jac = matrix(rows, n);
    d->Jdqd = vector(rows);
    d->Jv = matrix(s->nqv, s->nqv);
    d->Jvt = matrix(s->nqv, s->nqv);
    d->order = integers(s->nqv);
    d->B = matrix(s->nqv, n);
    d->bp = vector(s->nqv);
    d->MvB = matrix(s->nqv, n);
    d->Mr = matrix(n, n);
    d->Fr = vector(n);
    d->b = vector(most);
    d->uc = integers(n);
    for (int i = 1; i <= s->nqu; i++)
        d->uc[i] = s->qu[i];
    for (int i = 1; i <= s->nqc; i++)
        d->uc[s->nqu + i] = s->qc[i];
    return d;
}

/* A simulation with one of the two ways; without a dense step it is
   mbs_accelred's. */
typedef struct Simulation
{
    MbsData *s;
    DenseStep *d;
    double seconds;
    int rounds;
} Simulation;

static void derivative(Simulation *simulation, double t, const double *y, double *f)
{
    MbsData *s = simulation->s;
    int rounds;
    s->tsim = t;
    for (int i = 1; i <= s->nqu; i++) {
        s->q[s->qu[i]] = y[i];
        s->qd[s->qu[i]] = y[s->nqu + i];
    }
    rounds = simulation->d ? dense_step(s, simulation->d) : mbs_accelred(s, t);
    if (rounds < 0) {
        fprintf(stderr, "the loops do not close at %g s\n", t);
        exit(3);
    }
    if (rounds > simulation->rounds)
        simulation->rounds = rounds;
    for (int i = 1; i <= s->nqu; i++) {
        f[i] = s->qd[s->qu[i]];
        f[s->nqu + i] = s->qdd[s->qu[i]];
    }
}

/* One step of the classical Runge-Kutta method. */
static void advance(Simulation *simulation, double t, double step, double *y, double **work)
{
    static const double times[] = {0, 0, 0.5, 0.5, 1}, weights[] = {0, 1, 2, 2, 1};
    const int n = 2 * simulation->s->nqu;
    double *sum = work[1], *at = work[2], *f = work[3];
    struct timespec before, after;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
    memset(sum, 0, ((size_t)n + 1) * sizeof(double));
    memset(f, 0, ((size_t)n + 1) * sizeof(double));
    for (int stage = 1; stage <= 4; stage++) {
        for (int i = 1; i <= n; i++)
            at[i] = y[i] + times[stage] * step * f[i];
        derivative(simulation, t + times[stage] * step, at, f);
        for (int i = 1; i <= n; i++)
            sum[i] += weights[stage] / 6 * step * f[i];
    }
    for (int i = 1; i <= n; i++)
        y[i] += sum[i];
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
    simulation->seconds += (double)(after.tv_sec - before.tv_sec);
    simulation->seconds += 1e-9 * (double)(after.tv_nsec - before.tv_nsec);
}

/* The largest difference of multipliers and forces of driven joints, in parts
   of the largest. */
static double forces_apart(const MbsData *one, const MbsData *other)
{
    double largest = 0, apart = 0;
    for (int i = 1; i <= one->nhu; i++) {
        largest = fmax(largest, fabs(one->lambda[i]));
        apart = fmax(apart, fabs(one->lambda[i] - other->lambda[i]));
    }
    for (int i = 1; i <= one->njoint; i++) {
        largest = fmax(largest, fabs(one->Qc[i]));
        apart = fmax(apart, fabs(one->Qc[i] - other->Qc[i]));
    }
    return largest > 0 ? apart / largest : 0;
}

#ifdef ACTUATORS
/* Asks for forces of actuators that accelerate independent joints in a certain
   way, lets them act, and gives the largest difference in parts of the largest
   acceleration; infinite when something fails. */
static double actuators_apart(MbsData *s)
{
    double *wanted = vector(s->nqu), largest = 1, apart = 0;
    for (int i = 1; i <= s->nqu; i++)
        s->qdd[s->qu[i]] = wanted[i] = cos(i);
    if (mbs_invdynared(s, s->tsim) < 0)
        return INFINITY;
    for (int i = 1; i <= s->nqu; i++)
        s->Qx[s->qu[i]] = s->Qa[s->qu[i]];
    if (mbs_accelred(s, s->tsim) < 0)
        return INFINITY;
    for (int i = 1; i <= s->njoint; i++)
        largest = fmax(largest, fabs(s->qdd[i]));
    for (int i = 1; i <= s->nqu; i++)
        apart = fmax(apart, fabs(s->qdd[s->qu[i]] - wanted[i]));
    return apart / largest;
}
#endif

int main(int count, char **words)
{
    if (count != 4) {
        fprintf(stderr, "usage: host DATA SECONDS STEPS\n");
        return 2;
    }
    const double seconds = atof(words[2]);
    const int steps = atoi(words[3]);
    Simulation both[2] = {{load(words[1]), NULL, 0, 0}, {load(words[1]), NULL, 0, 0}};
    both[0].d = dense(both[0].s);
    const int nqu = both[0].s->nqu, joints = both[0].s->njoint;
    if (both[0].s->nqv > 0 && !dense_rows(both[0].s, both[0].d)) {
        fprintf(stderr, "no rows determine the dependent joints\n");
        return 3;
    }
    memcpy(both[1].s->hu, both[0].s->hu, ((size_t)both[0].s->nhu + 1) * sizeof(int));
    double largest = 0, apart = 0, forces = 0, actuators = 0;
    double *y[2], **work = matrix(3, 2 * nqu);
    for (int way = 0; way < 2; way++) {
        y[way] = vector(2 * nqu);
        for (int i = 1; i <= nqu; i++) {
            y[way][i] = both[way].s->q[both[way].s->qu[i]];
            y[way][nqu + i] = both[way].s->qd[both[way].s->qu[i]];
        }
    }
    for (int k = 0; k < steps; k++) {
        for (int way = 0; way < 2; way++)
            advance(&both[way], k * seconds / steps, seconds / steps, y[way], work);
        if (k == 0)
            forces = forces_apart(both[0].s, both[1].s);
        for (int joint = 1; joint <= joints; joint++) {
            const double one = both[0].s->q[joint], other = both[1].s->q[joint];
            largest = fmax(largest, fabs(one));
            /* What is no number is as far as can be. */
            if (!(fabs(one - other) <= apart))
                apart = fabs(one - other);
        }
    }
#ifdef ACTUATORS
    actuators = actuators_apart(both[1].s);
#endif
    printf("%.3e %.6g %.3e %.3e %d %d %.3e %.3e\n", apart / largest, largest,
           both[0].seconds / (4.0 * steps), both[1].seconds / (4.0 * steps), both[0].rounds,
           both[1].rounds, forces, actuators);
    return 0;
}
