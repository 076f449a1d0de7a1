/* @name@ for batches of @lanes@ states by robovec.

   Arrays of runs, for @name@_batch and @name@_many: every element has @lanes@ numbers one
   behind the other, one for each state of a batch, and batches follow each other.
   Element e of array A of state s is
       A[(s / @lanes@ * @name@_SIZE_A + e) * @lanes@ + s % @lanes@].
   Arrays of states, for @name@_states: A[s * @name@_SIZE_A + e].
   Elements count from 1: e is i for A[i] and i * (columns + 1) + j for A[i][j]; what has an
   index 0 is not used. A scalar has e = 0. Arrays need no alignment; runs that begin at
   multiples of their length in bytes are fastest. Arrays may not overlap.
@shared@@boundaries@
   _many and _states return 0, or -1 when there is no memory. */
#ifndef ROBOVEC_@upper@_BATCH_H
#define ROBOVEC_@upper@_BATCH_H

/* States of a batch, and numbers that are prepared for all. */
#define @name@_LANES @lanes@
#define @name@_PREPARED @prepared@

/* Runs of a batch, or numbers of a state, in each array. */
@sizes@
#ifdef __cplusplus
extern "C" {
#endif

@declarations@#ifdef __cplusplus
}
#endif

#endif
