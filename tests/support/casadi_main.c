/* Calls the functions of g_casadi.c as CasADi does, and prints how many inputs
   and outputs each has, the sparsities of its outputs, and whether they agree. */
#include "g_casadi.c"
#include <math.h>
#include <stdio.h>

enum { MOST = 40, SIZE = 64 };
typedef int call(const double **, double **, casadi_int *, double *, int);

static int failed;

/* The elements of a compressed pattern, spread over a dense matrix by columns. */
static void spread(const casadi_int *pattern, const double *given, double *dense)
{
    const casadi_int rows = pattern[0], columns = pattern[1];
    for (int k = 0; k < rows * columns; k++) dense[k] = 0;
    if (rows > 0 && columns > 0 && pattern[2] == 1) {
        for (int k = 0; k < rows * columns; k++) dense[k] = given[k];
        return;
    }
    const casadi_int *start = pattern + 2, *row = start + columns + 1;
    for (int j = 0; j < columns; j++)
        for (casadi_int k = start[j]; k < start[j + 1]; k++) dense[row[k] + j * rows] = given[k];
}

static void print(const char *name, casadi_int in, casadi_int out, const char *(*names)(casadi_int),
                  const casadi_int *(*patterns)(casadi_int))
{
    printf("%s: %d inputs, %d outputs\n", name, (int)in, (int)out);
    for (casadi_int i = 0; i < out; i++) {
        const casadi_int *p = patterns(i);
        double count[SIZE], ones[SIZE];
        for (int k = 0; k < SIZE; k++) ones[k] = 1;
        spread(p, ones, count);
        int nonzeros = 0;
        for (int k = 0; k < p[0] * p[1]; k++) nonzeros += count[k] != 0;
        printf("  %s %dx%d, %d\n", names(i), (int)p[0], (int)p[1], nonzeros);
    }
}

static void agree(const char *what, double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance * (1 + fabs(b)))) {
        printf("%s: %.17g is not %.17g\n", what, a, b);
        failed = 1;
    }
}

/* Calls a function; the outputs are dense, one after the other. */
static void values(call *f, const casadi_int *(*patterns)(casadi_int), casadi_int count,
                   const double **arg, double *dense)
{
    static double work[4096], room[MOST][SIZE];
    double *res[MOST];
    for (int i = 0; i < count; i++) res[i] = room[i];
    f(arg, res, 0, work, 0);
    for (int i = 0; i < count; i++) {
        const casadi_int *p = patterns(i);
        spread(p, room[i], dense);
        dense += p[0] * p[1];
    }
}

int main(void)
{
    enum { NX = 8, NY = 9 };
    /* t, x, A, and y, B, e, each one after the other. */
    const int inputs[] = {1, 3, 4}, outputs[] = {2, 6, 1};
    double x[NX] = {0.3, 0.7, 1.1, -0.4, 0.9, 0.2, -0.6, 1.3}, d[NX], w[NY], dw[NY];
    for (int k = 0; k < NX; k++) d[k] = 0.1 * k - 0.3;
    for (int k = 0; k < NY; k++) w[k] = 0.5 - 0.2 * k, dw[k] = 0.1 + 0.3 * k;
    const double *arg[MOST] = {x, x + 1, x + 4};
    double y[NY], jac[NX * NY], fwd[NY], adj[NX];

    print("g", g_n_in(), g_n_out(), g_name_out, g_sparsity_out);
    print("jac_g", jac_g_n_in(), jac_g_n_out(), jac_g_name_out, jac_g_sparsity_out);
    print("fwd1_g", fwd1_g_n_in(), fwd1_g_n_out(), fwd1_g_name_out, fwd1_g_sparsity_out);
    print("adj1_g", adj1_g_n_in(), adj1_g_n_out(), adj1_g_name_out, adj1_g_sparsity_out);
    print("jac_adj1_g", jac_adj1_g_n_in(), jac_adj1_g_n_out(), jac_adj1_g_name_out, jac_adj1_g_sparsity_out);
    print("fwd1_adj1_g", fwd1_adj1_g_n_in(), fwd1_adj1_g_n_out(), fwd1_adj1_g_name_out, fwd1_adj1_g_sparsity_out);
    print("fwd1_fwd1_g", fwd1_fwd1_g_n_in(), fwd1_fwd1_g_n_out(), fwd1_fwd1_g_name_out, fwd1_fwd1_g_sparsity_out);
    print("adj1_fwd1_g", adj1_fwd1_g_n_in(), adj1_fwd1_g_n_out(), adj1_fwd1_g_name_out, adj1_fwd1_g_sparsity_out);
    if (g_name_in(3) || g_sparsity_in(-1) || g_sparsity_out(3)) failed = 1;

    values(g, g_sparsity_out, 3, arg, y);
    agree("y[1]", y[0], sin(0.7) * x[6] + 0.3, 1e-15);
    agree("B[2,1]", y[3], sqrt(1.1) * 0.3, 1e-15);

    /* The Jacobian, block by block, as one matrix by columns. */
    double blocks[NX * NY];
    values(jac_g, jac_g_sparsity_out, 9, arg, blocks);
    for (int o = 0, row = 0, at = 0; o < 3; row += outputs[o++])
        for (int i = 0, column = 0; i < 3; column += inputs[i++])
            for (int c = 0; c < inputs[i]; c++)
                for (int r = 0; r < outputs[o]; r++) jac[row + r + NY * (column + c)] = blocks[at++];
    for (int c = 0; c < NX; c++) {
        double high[NY], low[NY], h = 1e-6, old = x[c];
        x[c] = old + h;
        values(g, g_sparsity_out, 3, arg, high);
        x[c] = old - h;
        values(g, g_sparsity_out, 3, arg, low);
        x[c] = old;
        for (int r = 0; r < NY; r++) agree("jac", jac[r + NY * c], (high[r] - low[r]) / (2 * h), 1e-8);
    }

    const double *with[MOST] = {x, x + 1, x + 4, 0, 0, 0, d, d + 1, d + 4};
    values(fwd1_g, fwd1_g_sparsity_out, 3, with, fwd);
    for (int r = 0; r < NY; r++) {
        double sum = 0;
        for (int c = 0; c < NX; c++) sum += jac[r + NY * c] * d[c];
        agree("fwd1", fwd[r], sum, 1e-14);
    }
    const double *weighted[MOST] = {x, x + 1, x + 4, 0, 0, 0, w, w + 2, w + 8};
    values(adj1_g, adj1_g_sparsity_out, 3, weighted, adj);
    for (int c = 0; c < NX; c++) {
        double sum = 0;
        for (int r = 0; r < NY; r++) sum += jac[r + NY * c] * w[r];
        agree("adj1", adj[c], sum, 1e-14);
    }

    /* The product with the Hessian, against differences of adjoints, and against
       the Jacobian of the adjoint. */
    double product[NX], second[NX * (NX + NY + NY)], high[NX], low[NX], h = 1e-6;
    const double *both[MOST] = {x, x + 1, x + 4, 0, 0, 0, w, w + 2, w + 8, 0, 0, 0,
                                d, d + 1, d + 4, 0, 0, 0, dw, dw + 2, dw + 8};
    values(fwd1_adj1_g, fwd1_adj1_g_sparsity_out, 3, both, product);
    for (int side = 1; side >= -1; side -= 2) {
        double moved[NX], weights[NY];
        for (int c = 0; c < NX; c++) moved[c] = x[c] + side * h * d[c];
        for (int r = 0; r < NY; r++) weights[r] = w[r] + side * h * dw[r];
        const double *there[MOST] = {moved, moved + 1, moved + 4, 0, 0, 0, weights, weights + 2, weights + 8};
        values(adj1_g, adj1_g_sparsity_out, 3, there, side > 0 ? high : low);
    }
    for (int c = 0; c < NX; c++) agree("fwd1_adj1", product[c], (high[c] - low[c]) / (2 * h), 1e-8);
    values(jac_adj1_g, jac_adj1_g_sparsity_out, 27, weighted, second);
    double sums[NX] = {0};
    for (int o = 0, row = 0, at = 0; o < 3; row += inputs[o++])
        for (int i = 0; i < 9; i++) {
            const int size = i < 3 ? inputs[i] : outputs[i % 3];
            const double *by = i < 3 ? d : dw;
            const int first = i == 0 ? 0 : i == 1 ? 1 : i == 2 ? 4 : i == 6 ? 0 : i == 7 ? 2 : 8;
            for (int c = 0; c < size; c++)
                for (int r = 0; r < inputs[o]; r++) sums[row + r] += second[at++] * (i >= 3 && i < 6 ? 0 : by[first + c]);
        }
    for (int c = 0; c < NX; c++) agree("jac_adj1", sums[c], product[c], 1e-14);

    /* The same from directions: along other directions, and back from weights. */
    double e[NX], twice[NY], back[NX + NY + NX];
    for (int c = 0; c < NX; c++) e[c] = 0.4 - 0.15 * c;
    const double *along[MOST] = {x, x + 1, x + 4, 0, 0, 0, d, d + 1, d + 4, 0, 0, 0,
                                 e, e + 1, e + 4, 0, 0, 0, 0, 0, 0};
    values(fwd1_fwd1_g, fwd1_fwd1_g_sparsity_out, 3, along, twice);
    const double *returned[MOST] = {x, x + 1, x + 4, 0, 0, 0, d, d + 1, d + 4, 0, 0, 0, w, w + 2, w + 8};
    values(adj1_fwd1_g, adj1_fwd1_g_sparsity_out, 9, returned, back);
    double forth = 0, to = 0;
    for (int r = 0; r < NY; r++) forth += w[r] * twice[r];
    for (int c = 0; c < NX; c++) {
        to += back[c] * e[c];
        agree("adj1_fwd1", back[NX + NY + c], adj[c], 1e-14);
    }
    agree("fwd1_fwd1", forth, to, 1e-14);
    for (int side = 1; side >= -1; side -= 2) {
        double moved[NX], end[NY];
        for (int c = 0; c < NX; c++) moved[c] = x[c] + side * h * e[c];
        const double *there[MOST] = {moved, moved + 1, moved + 4, 0, 0, 0, d, d + 1, d + 4};
        values(fwd1_g, fwd1_g_sparsity_out, 3, there, end);
        for (int r = 0; r < NY; r++) twice[r] -= side * end[r] / (2 * h);
    }
    for (int r = 0; r < NY; r++) agree("fwd1_fwd1 and differences", twice[r], 0, 1e-8);

    /* Arrays that are not given are zero; results nobody asks for are left out. */
    double sum = 7, work[64];
    const double *none[3] = {0, x + 1, 0};
    double *one[3] = {0, 0, &sum};
    g(none, one, 0, work, 0);
    agree("e", sum, x[1] * x[2] * x[3], 1e-15);
    printf(failed ? "they differ\n" : "they agree\n");
    return failed;
}
