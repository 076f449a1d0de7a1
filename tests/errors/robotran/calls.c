void mbs_extforces(double **frc, double **trq, MbsData *s, double tsim)
{
double PxF1[4];
double *SWr1;
frc[1][1] = SWr1[1]+PxF1[2];
PxF1[1] = s->q[1];
SWr1 = user_ExtForces(PxF1,s,tsim,1);
PxF1[1] = s->q[2];
F1 = user_LinkForces(-s->q[1],s->q[2],s,tsim,1);
F1 = user_LinkForces(F1,F1,s,tsim,1);
F2 = interpolate(F1);
trq[1][1] = F1+F2;
}
