#
#	A quarter of a car with double wishbones, written for robovec
#	in the style of Robotran's files. The model: README.md
#
#	==> Project name : suspension
#
#	==> Number of joints : 5
#
#	==> Function : F 2 : Inverse Dynamics
#

from math import sin, cos

def invdyna(phi, s, tsim):
    Qq = phi
    q = s.q
    qd = s.qd
    qdd = s.qdd

# Trigonometric functions

    C2 = cos(q[2])
    S2 = sin(q[2])
    C3 = cos(q[3])
    S3 = sin(q[3])
    C4 = cos(q[4])
    S4 = sin(q[4])
    C5 = cos(q[5])
    S5 = sin(q[5])

# Forward Kinematics

    ALPHA31 = qdd[1]-s.g[3]
    BS52 = -qd[2]*qd[2]
    ALPHA22 = ALPHA31*S2
    ALPHA32 = ALPHA31*C2
    OM13 = qd[2]+qd[3]
    OMp13 = qdd[2]+qdd[3]
    BS53 = -OM13*OM13
    BS93 = -OM13*OM13
    BETA63 = -OMp13
    ALPHA23 = ALPHA22*C3+BS52*s.dpt[2,4]*C3+ALPHA32*S3+qdd[2]*s.dpt[2,4]*S3
    ALPHA33 = ALPHA32*C3+qdd[2]*s.dpt[2,4]*C3-ALPHA22*S3-BS52*s.dpt[2,4]*S3
    BS54 = -qd[4]*qd[4]
    ALPHA24 = ALPHA31*S4
    ALPHA34 = ALPHA31*C4
    OM15 = OM13*C5
    OM35 = OM13*S5
    OMp15 = OMp13*C5-qd[5]*OM13*S5
    OMp35 = OMp13*S5+qd[5]*OM13*C5
    ALPHA15 = -ALPHA33*S5-OMp13*s.dpt[2,7]*S5-BS93*s.dpt[3,7]*S5
    ALPHA25 = ALPHA23+BS53*s.dpt[2,7]+BETA63*s.dpt[3,7]
    ALPHA35 = ALPHA33*C5+OMp13*s.dpt[2,7]*C5+BS93*s.dpt[3,7]*C5

# Backward Dynamics

    Fs15 = ALPHA15*s.m[5]-s.frc[1,5]
    Fs25 = ALPHA25*s.m[5]-s.frc[2,5]
    Fs35 = ALPHA35*s.m[5]-s.frc[3,5]
    Cq15 = s.In[1,5]*OMp15+qd[5]*s.In[9,5]*OM35-s.trq[1,5]-qd[5]*s.In[5,5]*OM35
    Cq25 = qdd[5]*s.In[5,5]+s.In[1,5]*OM15*OM35-s.trq[2,5]-s.In[9,5]*OM15*OM35
    Cq35 = s.In[9,5]*OMp35+qd[5]*s.In[5,5]*OM15-s.trq[3,5]-qd[5]*s.In[1,5]*OM15
    Fs24 = ALPHA24*s.m[4]+BS54*s.l[2,4]*s.m[4]-s.frc[2,4]
    Fs34 = ALPHA34*s.m[4]+qdd[4]*s.l[2,4]*s.m[4]-s.frc[3,4]
    Cq14 = Fs34*s.l[2,4]+qdd[4]*s.In[1,4]-s.trq[1,4]
    Fs23 = ALPHA23*s.m[3]+BS53*s.l[2,3]*s.m[3]+BETA63*s.l[3,3]*s.m[3]-s.frc[2,3]
    Fs33 = ALPHA33*s.m[3]+OMp13*s.l[2,3]*s.m[3]+BS93*s.l[3,3]*s.m[3]-s.frc[3,3]
    Fq23 = Fs23+Fs25
    Fq33 = Fs33+Fs35*C5-Fs15*S5
    Cq13 = Fs33*s.l[2,3]+s.In[1,3]*OMp13+Cq15*C5+Cq35*S5+Fs35*s.dpt[2,7]*C5-s.trq[1,3]-Fs23* \
	s.l[3,3]-Fs15*s.dpt[2,7]*S5-Fs25*s.dpt[3,7]
    Fs22 = ALPHA22*s.m[2]+BS52*s.l[2,2]*s.m[2]-s.frc[2,2]
    Fs32 = ALPHA32*s.m[2]+qdd[2]*s.l[2,2]*s.m[2]-s.frc[3,2]
    Fq22 = Fs22+Fq23*C3-Fq33*S3
    Fq32 = Fs32+Fq23*S3+Fq33*C3
    Cq12 = Fs32*s.l[2,2]+qdd[2]*s.In[1,2]+Cq13+Fq23*s.dpt[2,4]*S3+Fq33*s.dpt[2,4]*C3-s.trq[1,2]
    Fs31 = ALPHA31*s.m[1]-s.frc[3,1]
    Fq31 = Fs31+Fq22*S2+Fq32*C2+Fs24*S4+Fs34*C4

# Symbolic model output

    Qq[1] = Fq31
    Qq[2] = Cq12
    Qq[3] = Cq13
    Qq[4] = Cq14
    Qq[5] = Cq25

# Number of continuation lines = 1
