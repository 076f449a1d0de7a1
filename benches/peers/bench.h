/* What every timed program has: a clock, windows, results.

   A program offers two functions. bench_evaluate(g) evaluates the states of
   group g, BENCH_LANES of them at once; bench_result(g, l, out) gives the
   results of state l of this group after that. bench_run writes the results of
   all states to a file and then prints the least time per state in ns:
   processor time of the thread, windows of about 2 ms. */
#ifndef ROBOVEC_BENCH_H
#define ROBOVEC_BENCH_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef BENCH_LANES
#define BENCH_LANES 1
#endif

static void bench_evaluate(int group);
static void bench_result(int group, int lane, double *out);

static void bench_fail(const char *message)
{
    fprintf(stderr, "%s\n", message);
    exit(1);
}

static double bench_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double bench_window(int groups, long calls)
{
    const double start = bench_now();
    for (long i = 0; i < calls; i++) bench_evaluate((int)(i % groups));
    return bench_now() - start;
}

static int bench_run(int states, size_t results, const char *name, double milliseconds)
{
    const int groups = states / BENCH_LANES;
    FILE *file = fopen(name, "wb");
    double *out = (double *)calloc(results ? results : 1, sizeof(double));
    if (!file || !out || groups < 1) bench_fail("the results cannot be written");
    for (int g = 0; g < groups; g++) {
        bench_evaluate(g);
        for (int l = 0; l < BENCH_LANES; l++) {
            bench_result(g, l, out);
            if (fwrite(out, sizeof(double), results, file) != results)
                bench_fail("the results cannot be written");
        }
    }
    if (fclose(file)) bench_fail("the results cannot be written");
    free(out);
    long calls = 1;
    while (bench_window(groups, calls) < 2e6) calls *= 2;
    double least = 1e300, spent = 0.0;
    while (spent < 1e6 * milliseconds) {
        const double time = bench_window(groups, calls);
        spent += time;
        if (time / (double)calls < least) least = time / (double)calls;
    }
    printf("%.3f\n", least / BENCH_LANES);
    return 0;
}

#endif
