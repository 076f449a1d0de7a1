/* What every timed program has: a clock, windows, results.

   A program offers two functions. bench_evaluate(g) evaluates the states of
   group g, BENCH_LANES of them at once; bench_result(g, l, out) gives the
   results of state l of this group after that. bench_run writes the results of
   all states to a file and then prints the least time per state in ns:
   processor time of the thread, windows of about 2 ms. Behind it stands, where
   there is time for BENCH_LEAST calls, how much longer one call in a thousand
   takes than the median one, in ns: calls timed one by one on the wall, so that
   the time of reading the clock falls out of the difference. */
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

#define BENCH_MOST 10000
#define BENCH_LEAST 2000

static int bench_order(const void *one, const void *other)
{
    const double a = *(const double *)one, b = *(const double *)other;
    return (a > b) - (a < b);
}

static double bench_wall(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* The 99.9th percentile of the times of so many calls, less their median. */
static double bench_jitter(int groups, long calls)
{
    static double times[BENCH_MOST];
    for (long i = 0; i < calls; i++) {
        const double start = bench_wall();
        bench_evaluate((int)(i % groups));
        times[i] = bench_wall() - start;
    }
    qsort(times, (size_t)calls, sizeof(double), bench_order);
    return times[(calls * 999 + 999) / 1000 - 1] - times[(calls + 1) / 2 - 1];
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
    printf("%.3f", least / BENCH_LANES);
    /* No more than a quarter of the time again. */
    const double fitting = 0.25e6 * milliseconds / (least > 1.0 ? least : 1.0);
    const long singles = fitting < BENCH_MOST ? (long)fitting : BENCH_MOST;
    if (singles >= BENCH_LEAST) printf(" %.1f", bench_jitter(groups, singles));
    printf("\n");
    return 0;
}

#endif
