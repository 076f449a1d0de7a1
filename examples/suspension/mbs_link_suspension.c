//
//	A quarter of a car with double wishbones, written for robovec
//	in the style of Robotran's files. The model: README.md
//
//	==> Project name : suspension
//
//	==> Number of joints : 5
//
//	==> Function : F 7 : Point to point Link Forces (frc,trq,Flink)
//

#include <math.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"

void mbs_link(double **frc, double **trq, double *Flink, double *Z, double *Zd,
MbsData *s, double tsim)
{
#include "mbs_link_suspension.h"

double *q, *qd;
double **dpt, **l;

q = s->q;
qd = s->qd;
dpt = s->dpt;
l = s->l;
frc = s->frc;
trq = s->trq;

// Trigonometric functions

C2 = cos(q[2]);
S2 = sin(q[2]);

// Link anchor points Kinematics

ROlnk1_82 = -S2;
RLlnk1_2p = dpt[2][5]*C2+ROlnk1_82*dpt[3][5];
RLlnk1_3p = dpt[2][5]*S2+dpt[3][5]*C2;
POlnk1_2p = dpt[2][1]+RLlnk1_2p;
POlnk1_3p = dpt[3][1]+RLlnk1_3p;
ORlnk1_2p = -qd[2]*RLlnk1_3p;
ORlnk1_3p = qd[2]*RLlnk1_2p;
Plnk21 = POlnk1_2p-dpt[2][3];
Plnk31 = POlnk1_3p-dpt[3][3];
Z1 = sqrt(Plnk21*Plnk21+Plnk31*Plnk31);
e21 = Plnk21/Z1;
e31 = Plnk31/Z1;
Zd1 = ORlnk1_2p*e21+ORlnk1_3p*e31;

// Link Forces

Flink1 = user_LinkForces(Z1,Zd1,s,tsim,1);

// Link Dynamics: forces projection on body-fixed frames

fPlnk21 = Flink1*e21;
fPlnk31 = Flink1*e31;
fSlnk21 = Flink1*e21*C2+Flink1*e31*S2;
fSlnk31 = Flink1*e31*C2-Flink1*e21*S2;
frc[2][1] = frc[2][1]+fPlnk21;
frc[3][1] = frc[3][1]+fPlnk31;
trq[1][1] = trq[1][1]+dpt[2][3]*fPlnk31-dpt[3][3]*fPlnk21;
frc[2][2] = frc[2][2]-fSlnk21;
frc[3][2] = frc[3][2]-fSlnk31;
Alnk21 = dpt[2][5]-l[2][2];
trq[1][2] = trq[1][2]+dpt[3][5]*fSlnk21-Alnk21*fSlnk31;

// Symbolic model output

Z[1] = Z1;
Zd[1] = Zd1;
Flink[1] = Flink1;

// Number of continuation lines = 0

}
