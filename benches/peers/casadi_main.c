/* CasADi's generated function: double dynamics(arg, res, iw, w, mem). */
#include "peer.h"

typedef long long int integer;
int dynamics(const double **arg, double **res, integer *iw, double *w, int mem);
int dynamics_work(integer *arg, integer *res, integer *iw, integer *w);

static double *M_out, *c_out, *w;
static integer *iw;

static void peer_evaluate(int s)
{
    const double *arg[16] = {peer_q + (size_t)s * (size_t)peer_joints,
                             peer_qd + (size_t)s * (size_t)peer_joints};
    double *res[16] = {M_out, c_out};
    dynamics(arg, res, iw, w, 0);
}

static void peer_result(double *M, double *c)
{
    const size_t n = (size_t)peer_joints;
    memcpy(M, M_out, n * n * sizeof *M);
    memcpy(c, c_out, n * sizeof *c);
}

int main(int count, char **words)
{
    integer arguments = 0, results = 0, integers = 0, reals = 0;
    peer_read(count, words);
    dynamics_work(&arguments, &results, &integers, &reals);
    if (arguments > 16 || results > 16) bench_fail("CasADi wants more arguments");
    const size_t n = (size_t)peer_joints;
    M_out = (double *)calloc(n * n, sizeof *M_out);
    c_out = (double *)calloc(n, sizeof *c_out);
    w = (double *)calloc((size_t)reals + 1, sizeof *w);
    iw = (integer *)calloc((size_t)integers + 1, sizeof *iw);
    return peer_main(count, words);
}
