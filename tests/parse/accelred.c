// Reduced accelerations with a Newton loop that closes the loops.
int mbs_accelred(MbsData *s, double tsim)
{
#include "mbs_accelred_small.h"
int NR_iter = 0;
double *q, *qd, *qdd;
double *Qq;
q = s->q;
qd = s->qd;
qdd = s->qdd;
// Loop Closure Threshold
NR_ERR2 = (0.50)*s->l[1][1];
NRh2 = (1.0);
C1 = cos(q[1]);
S1 = sin(q[1]);
while((NRh2 > NR_ERR2) && (NR_iter++ < MAX_NR_ITER)) {
C2 = cos(q[2]);
S2 = sin(q[2]);
h_1 = C1*S2-s->dpt[1][1];
Jac_1_2 = C1*C2;
NRh2_1 = h_1*h_1;
NRh2 = NRh2_1;
if (NRh2 > NR_ERR2)
{
Jv_hx1 = h_1/Jac_1_2;
q[2] = q[2]-Jv_hx1;
}
}
Bvu1x1 = -S1/Jac_1_2;
qd[2] = qd[1]*Bvu1x1;
Qq = user_call_JointForces(s,tsim);
qdd[1] = Qq[1]/(s->m[1]+Bvu1x1*Bvu1x1);
qdd[2] = qdd[1]*Bvu1x1+qd[2]*qd[2];
return MBS_INFO_SUCCESS;
}
