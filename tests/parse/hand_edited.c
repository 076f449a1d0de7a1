// What people do to generated files.
#include <math.h>
//#define PARALLEL
#ifdef PARALLEL
#pragma omp parallel
this is not read
#else
void helper(double *x);
#endif
void dirdyna(double **M,double *c,
MBSdataStruct *s, double tsim)
// double M[2][2];
{
 #define q s->q
 #define torque s->trq
  double mass = 2.0, half;
  int i;
  M [ 1 ][ 2 ]  = M[2] [1]  = q[1]*q[2];
  M[1][1] = M[2][2] = mass;
  c[1] = torque[1][2]; c[2] = -(s->frc[1][2]);
}
