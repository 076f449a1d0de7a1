/* @name@ for batches of @lanes@ states by robovec. Compile with -O3 and for the processor at
   hand (-march=native), with -fopenmp to use its cores. */
#include "@name@_batch.h"
#include <stdlib.h>
@types@@runs@
/* The lanes of an element of an array, whose address may be any. */
#define IN(array, element) (*(const @unaligned@ *)((array) + (element) * @lanes@))
#define OUT(array, element) (*(@unaligned@ *)((array) + (element) * @lanes@))

/* Parts stay apart: compilers are fast for short functions only. */
@apart@
@root_function@