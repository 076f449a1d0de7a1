/* CasADi's generated function: double dynamics(arg, res, iw, w, mem). */
#include "peer.h"

typedef long long int integer;
int dynamics(const double **arg, double **res, integer *iw, double *w, int mem);
int dynamics_work(integer *arg, integer *res, integer *iw, integer *w);

static double *first, *second, *third, *w;
static integer *iw;

static void peer_evaluate(int s)
{
    const size_t n = (size_t)peer_joints, given = peer_wanted == PEER_DIRDYNA ? 0 : n;
    const double *arg[16] = {peer_group(peer_q, s, n), peer_group(peer_qd, s, n),
                             peer_group(peer_given, s, given),
                             peer_group(peer_loads, s, peer_has_loads ? 6 * n : 0)};
    double *res[16] = {first, second, third};
    dynamics(arg, res, iw, w, 0);
}

/* M and c, or what else was asked for alone; derivatives come column by column. */
static void peer_result(int lane, double *out)
{
    const size_t n = (size_t)peer_joints, matrix = peer_wanted == PEER_DIRDYNA ? n * n : n;
    const double *all[3] = {first, second, third};
    (void)lane;
    if (peer_wanted >= PEER_INVDYNA_D) {
        for (int k = 0; k < peer_matrices(); k++)
            for (size_t i = 0; i < n * n; i++) *out++ = all[k][i % n * n + i / n];
        return;
    }
    memcpy(out, first, matrix * sizeof *out);
    if (peer_wanted == PEER_DIRDYNA) memcpy(out + matrix, second, n * sizeof *out);
}

int main(int count, char **words)
{
    integer arguments = 0, results = 0, integers = 0, reals = 0;
    peer_read(count, words);
    dynamics_work(&arguments, &results, &integers, &reals);
    if (arguments > 16 || results > 16) bench_fail("CasADi wants more arguments");
    const size_t n = (size_t)peer_joints;
    first = (double *)calloc(n * n, sizeof *first);
    second = (double *)calloc(n * n, sizeof *second);
    third = (double *)calloc(n * n, sizeof *third);
    w = (double *)calloc((size_t)reals + 1, sizeof *w);
    iw = (integer *)calloc((size_t)integers + 1, sizeof *iw);
    return peer_main(count, words);
}
