// In C the parameter frc and s->frc are the same memory.
void mbs_link(double **frc, double **trq, double *Flink, double *Z, double *Zd,
MbsData *s, double tsim)
{
#include "mbs_link_aliases.h"
#define q s->q
#define qd s->qd
Z = s->Z;

  Z1 = sqrt(q[1]*q[1]+s->dpt[1][2]*s->dpt[1][2]);
  Zd1 = qd[1]*q[1]/Z1;
  Flink1 = user_LinkForces(Z1,Zd1,s,tsim,1);
  s->frc[1][2] = s->frc[1][2]+Flink1;
  frc[1][2] = frc[1][2]-q[1];
  frc[2][2] = s->frc[2][2];
  trq[1][2] = s->frc[1][2]*s->l[3][2];
  Flink[1] = Flink1;
  Z[1] = Z1;
  Zd[1] = Zd1;
}
