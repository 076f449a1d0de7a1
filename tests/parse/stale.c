//	==> Number of joints : 2
void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
Qq[1] = s->q[3]*s->frc[1][4]+tsim;
Qq[2] = s->tsim;
}
