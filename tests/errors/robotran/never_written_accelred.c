int mbs_accelred(MbsData *s, double tsim)
{
A = s->qdd[1]*s->qd[1];
return 0;
}
