void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
A1 = s->q[1]*A3;
A2 = A1+A1;
A3 = A2*s->q[2];
A4 = A5;
A5 = s->q[1];
A6 = A6+A5;
Qq[1] = A3+A6;
}
