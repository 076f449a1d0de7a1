#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A model without links, forces or loops leaves some of this unused, and an FMU
   has all functions of the interface. */
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-const-variable"
#pragma GCC diagnostic ignored "-Wtype-limits"
#endif

/* Types of FMI 3.0 (section 2.2). */
typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef int fmi3DependencyKind, fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, double, bool, bool, bool, bool, bool *, double *);
typedef void (*fmi3PreemptionCallback)(void);

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* A part of a generated function's numbers: the slots that its inputs come from,
   those that move before parameters, and the slots of its results. */
typedef struct {
    void (*run)(const double *numbers, double *results);
    const unsigned *from, *to;
    unsigned moving, inputs, results, place;
} Function;

typedef struct {
    unsigned slot;
    double value;
    int direction, stops;
} Event;

enum { POSITIONS, VELOCITIES, LENGTHS, LINK_LOADS, POINTS, POINT_LOADS, ACCELERATIONS, KINDS };

