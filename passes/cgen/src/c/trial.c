#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
@include@
@storage@
@contestants@
/* The state. */
static const struct { @real@ *place; double number; } given[] = {
@given@    {0, 0}
};

/* What comes of it. */
static const struct { @real@ *place; double number, norm; const char *name; } expected[] = {
@expected@    {0, 0, 1, 0}
};

static const double tolerance = @tolerance@;

static void set_up(void)
{
@set_up@}

static void clear(void)
{
@clear@}

static void call(int contestant)
{
    switch (contestant) {
@calls@    }
}

enum { CONTESTANTS = @count@ };
static const char *const names[] = {@names@};

static void fill(void)
{
    clear();
    for (int i = 0; given[i].place; i++)
        *given[i].place = (@real@)given[i].number;
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec * 1e9 + (double)time.tv_nsec;
}

/* Processor time of a call, in nanoseconds: the least of many windows. */
static void measure(double *best)
{
    long calls[CONTESTANTS];
    for (int k = 0; k < CONTESTANTS; k++) {
        calls[k] = 1;
        best[k] = INFINITY;
        for (;;) {
            const double start = now();
            for (long i = 0; i < calls[k]; i++) call(k);
            if (now() - start > 3e5) break;
            calls[k] *= 2;
        }
    }
    for (int window = 0; window < 200; window++)
        for (int k = 0; k < CONTESTANTS; k++) {
            const double start = now();
            for (long i = 0; i < calls[k]; i++) call(k);
            const double time = (now() - start) / (double)calls[k];
            if (time < best[k]) best[k] = time;
        }
}

int main(int count, char **arguments)
{
    const int prints = count > 1 && !strcmp(arguments[1], "print");
    const int times = count > 1 && !strcmp(arguments[1], "time");
    int differs = 0;
    set_up();
    for (int k = 0; k < CONTESTANTS; k++) {
        double worst = 0;
        const char *where = "";
        fill();
        set_up();
        call(k);
        for (int i = 0; expected[i].place; i++) {
            const double off = fabs((double)*expected[i].place - expected[i].number) / expected[i].norm;
            if (prints) printf("%s %s %.17g %.17g\n", names[k], expected[i].name,
                (double)*expected[i].place, expected[i].number);
            /* A NaN stays the worst. */
            if (worst == worst && !(off <= worst)) {
                worst = off;
                where = expected[i].name;
            }
        }
        printf("%s off by %.2e %s\n", names[k], worst, where);
        if (!(worst <= tolerance)) differs = 1;
    }
    if (times) {
        double best[CONTESTANTS];
        fill();
        set_up();
        measure(best);
        for (int k = 0; k < CONTESTANTS; k++)
            printf("%s ns %.1f ratio %.3f\n", names[k], best[k], best[0] / best[k]);
    }
    return differs;
}
