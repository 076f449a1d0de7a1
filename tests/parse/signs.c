/* Signs, sums and products as the two generators write them; a block
   comment over two lines. */
#include <math.h>
#include "mbs_data.h"

void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
#include "mbs_invdyna_signs.h"

double *q, *qd;
double **dpt;

q = s->q;
qd = s->qd;
dpt = s->dpt;

// A leading minus takes the whole first product.
A1 = -q[1]*qd[2]+q[2];
A2 = -(q[1]-A1+dpt[3][1]*(q[2]*A1-qd[1]*A1));
A3 = q[1]-q[2]-A2
 -q[1]*
 q[2]/A2;
A4 = A1*(-A2)*-A3;
A5 = (1.0);
A6 = -(2.0);
A7 = 0;
A8 = (0.50)*A6;
A9 = A7;
Qq[1] = A3+A4;
Qq[2] = A5*A8;
Qq[3] = A9;
Qq[4] = 0;
}
