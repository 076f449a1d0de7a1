// Direct dynamics of order N.
void mbs_dirdyna_odn(MBSdataStruct *s, double tsim)
{
#define q s->q
#define qdd s->qdd
  C1 = cos(q[1]);
  K11 = s->m[1]+0.500*C1;
  RO1 = (1.0)/K11;
  qdd[1] = RO1*s->trq[1][1];
}
