void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
A1 = s->q[1]*s->q[2];
Qq[1] = A1;
