void  mbs_sensor(MbsSensor *sens, 
              MbsData *s,
              int isens)
{ 
#include "mbs_sensor_small.h" 
#define q s->q 
  C1 = cos(q[1]);
  S1 = sin(q[1]);
switch(isens)
{
case 1:
    ROcp1_1 = C1*S1;
    sens->P[1] = ROcp1_1;
    sens->R[1][1] = (1.0);
break;
case 2: 
case 3:
    ROcp1_1 = C1+S1;
    sens->P[3] = ROcp1_1*ROcp1_1;
break;
default:
break;
}
}
