void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
Qq[1] = 1e999*s->q[1];
Qq[2] = inf;
Qq[4] = 1e-400;
Qq[3] = INFINITY*s->q[1];
}
