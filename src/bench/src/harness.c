#define BENCH_LANES @lanes@
#include "bench.h"
@header@
enum { STATES = @states@, LANES = @lanes@, INPUTS = @inputs@ };
@storage@static void fill(const double *in, int s)
{
    const int g = s / LANES, l = s % LANES;
    (void)g; (void)l; (void)in;
@fill@}
static void bench_evaluate(int g)
{
    (void)g;
@body@}
static void bench_result(int g, int l, double *out)
{
    (void)g; (void)l;
    @real@ *const output_base[] = { @bases@ };
    for (int i = 0; i < @outputs@; i++) out[i] = *(output_base[output_list[i][0]] + @place@);
}
int main(int count, char **words)
{
    static double in[INPUTS + 1];
    FILE *file = fopen("inputs.bin", "rb");
    if (!file) bench_fail("there are no states");
    for (int s = 0; s < STATES; s++) {
        if (fread(in, sizeof(double), INPUTS, file) != INPUTS) bench_fail("states are missing");
        fill(in, s);
    }
    fclose(file);
@before@    return bench_run(STATES, @outputs@, words[1], count > 2 ? atof(words[2]) : 100.0);
}
