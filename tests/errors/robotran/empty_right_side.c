void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
BeF211 = s->q[1]*s->q[2];
BeF221 = ;
Qq[1] = BeF211;
}
