void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
Qq[1] = s->q[1]; /* never closed
}
