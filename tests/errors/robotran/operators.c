void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
A1 = s->q[1]^2;
A2 = pow(s->q[1],2);
A3 = s->q[i]*2.0;
A4 = s->q[1] > 0 ? 1.0 : 2.0;
A5 += s->q[1];
A6 = s->q[1]*fabs(A1);
A7 = s->q[1] A6;
A8 = (s->q[1]+A6;
A9 = 2.0*;
1.0 = A9;
for (i = 0; i < 3; i++) { Qq[1] = A9; }
Qq[1] = A9;
}
