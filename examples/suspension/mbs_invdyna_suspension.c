//
//	A quarter of a car with double wishbones, written for robovec
//	in the style of Robotran's files. The model: README.md
//
//	==> Project name : suspension
//
//	==> Number of joints : 5
//
//	==> Function : F 2 : Inverse Dynamics
//

#include <math.h>

#include "mbs_data.h"

void mbs_invdyna(double *Qq,
MbsData *s, double tsim)
{
#include "mbs_invdyna_suspension.h"

double *q, *qd, *qdd, *m, *g;
double **dpt, **l, **In, **frc, **trq;

q = s->q;
qd = s->qd;
qdd = s->qdd;
dpt = s->dpt;
l = s->l;
m = s->m;
In = s->In;
g = s->g;
frc = s->frc;
trq = s->trq;

// Trigonometric functions

C2 = cos(q[2]);
S2 = sin(q[2]);
C3 = cos(q[3]);
S3 = sin(q[3]);
C4 = cos(q[4]);
S4 = sin(q[4]);
C5 = cos(q[5]);
S5 = sin(q[5]);

// Forward Kinematics

ALPHA31 = qdd[1]-g[3];
BS52 = -qd[2]*qd[2];
ALPHA22 = ALPHA31*S2;
ALPHA32 = ALPHA31*C2;
OM13 = qd[2]+qd[3];
OMp13 = qdd[2]+qdd[3];
BS53 = -OM13*OM13;
BS93 = -OM13*OM13;
BETA63 = -OMp13;
ALPHA23 = ALPHA22*C3+BS52*dpt[2][4]*C3+ALPHA32*S3+qdd[2]*dpt[2][4]*S3;
ALPHA33 = ALPHA32*C3+qdd[2]*dpt[2][4]*C3-ALPHA22*S3-BS52*dpt[2][4]*S3;
BS54 = -qd[4]*qd[4];
ALPHA24 = ALPHA31*S4;
ALPHA34 = ALPHA31*C4;
OM15 = OM13*C5;
OM35 = OM13*S5;
OMp15 = OMp13*C5-qd[5]*OM13*S5;
OMp35 = OMp13*S5+qd[5]*OM13*C5;
ALPHA15 = -ALPHA33*S5-OMp13*dpt[2][7]*S5-BS93*dpt[3][7]*S5;
ALPHA25 = ALPHA23+BS53*dpt[2][7]+BETA63*dpt[3][7];
ALPHA35 = ALPHA33*C5+OMp13*dpt[2][7]*C5+BS93*dpt[3][7]*C5;

// Backward Dynamics

Fs15 = ALPHA15*m[5]-frc[1][5];
Fs25 = ALPHA25*m[5]-frc[2][5];
Fs35 = ALPHA35*m[5]-frc[3][5];
Cq15 = In[1][5]*OMp15+qd[5]*In[9][5]*OM35-trq[1][5]-qd[5]*In[5][5]*OM35;
Cq25 = qdd[5]*In[5][5]+In[1][5]*OM15*OM35-trq[2][5]-In[9][5]*OM15*OM35;
Cq35 = In[9][5]*OMp35+qd[5]*In[5][5]*OM15-trq[3][5]-qd[5]*In[1][5]*OM15;
Fs24 = ALPHA24*m[4]+BS54*l[2][4]*m[4]-frc[2][4];
Fs34 = ALPHA34*m[4]+qdd[4]*l[2][4]*m[4]-frc[3][4];
Cq14 = Fs34*l[2][4]+qdd[4]*In[1][4]-trq[1][4];
Fs23 = ALPHA23*m[3]+BS53*l[2][3]*m[3]+BETA63*l[3][3]*m[3]-frc[2][3];
Fs33 = ALPHA33*m[3]+OMp13*l[2][3]*m[3]+BS93*l[3][3]*m[3]-frc[3][3];
Fq23 = Fs23+Fs25;
Fq33 = Fs33+Fs35*C5-Fs15*S5;
Cq13 = Fs33*l[2][3]+In[1][3]*OMp13+Cq15*C5+Cq35*S5+Fs35*dpt[2][7]*C5-trq[1][3]-Fs23*l[3][3]-Fs15*
 dpt[2][7]*S5-Fs25*dpt[3][7];
Fs22 = ALPHA22*m[2]+BS52*l[2][2]*m[2]-frc[2][2];
Fs32 = ALPHA32*m[2]+qdd[2]*l[2][2]*m[2]-frc[3][2];
Fq22 = Fs22+Fq23*C3-Fq33*S3;
Fq32 = Fs32+Fq23*S3+Fq33*C3;
Cq12 = Fs32*l[2][2]+qdd[2]*In[1][2]+Cq13+Fq23*dpt[2][4]*S3+Fq33*dpt[2][4]*C3-trq[1][2];
Fs31 = ALPHA31*m[1]-frc[3][1];
Fq31 = Fs31+Fq22*S2+Fq32*C2+Fs24*S4+Fs34*C4;

// Symbolic model output

Qq[1] = Fq31;
Qq[2] = Cq12;
Qq[3] = Cq13;
Qq[4] = Cq14;
Qq[5] = Cq25;

// Number of continuation lines = 1

}
