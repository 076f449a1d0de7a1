void mbs_sensor(MbsSensor *sens, MbsData *s, int isens)
{
case 1:
sens->P[1] = s->q[1];
}
}
Qq[1] = s->q[1];
