#
#	A quarter of a car with double wishbones, written for robovec
#	in the style of Robotran's files. The model: README.md
#
#	==> Project name : suspension
#
#	==> Number of joints : 5
#
#	==> Function : F19 : External Forces
#

from math import sin, cos
from numpy import zeros

def extforces(frc, trq, s, tsim):
    q = s.q
    qd = s.qd
    qdd = s.qdd
    frc = s.frc
    trq = s.trq
    PxF1 = zeros(4)
    VxF1 = zeros(4)
    OMxF1 = zeros(4)
    AxF1 = zeros(4)
    OMPxF1 = zeros(4)
    RxF1 = zeros((4, 4))

# Trigonometric functions

    C2 = cos(q[2])
    S2 = sin(q[2])
    C3 = cos(q[3])
    S3 = sin(q[3])
    C5 = cos(q[5])
    S5 = sin(q[5])

# Sensor Kinematics

    POcp1_32 = q[1]+s.dpt[3,1]
    ROcp1_82 = -S2
    RLcp1_23 = s.dpt[2,4]*C2
    RLcp1_33 = s.dpt[2,4]*S2
    POcp1_23 = s.dpt[2,1]+RLcp1_23
    POcp1_33 = POcp1_32+RLcp1_33
    ORcp1_23 = -qd[2]*RLcp1_33
    ORcp1_33 = qd[2]*RLcp1_23
    VIcp1_33 = qd[1]+ORcp1_33
    ACcp1_23 = -qdd[2]*RLcp1_33-qd[2]*ORcp1_33
    ACcp1_33 = qdd[1]+qdd[2]*RLcp1_23+qd[2]*ORcp1_23
    OPcp1_13 = qdd[2]+qdd[3]
    OMcp1_13 = qd[2]+qd[3]
    ROcp1_53 = C2*C3+ROcp1_82*S3
    ROcp1_63 = C3*S2+C2*S3
    ROcp1_83 = ROcp1_82*C3-C2*S3
    ROcp1_93 = C2*C3-S2*S3
    RLcp1_25 = ROcp1_53*s.dpt[2,7]+ROcp1_83*s.dpt[3,7]
    RLcp1_35 = ROcp1_63*s.dpt[2,7]+ROcp1_93*s.dpt[3,7]
    POcp1_25 = POcp1_23+RLcp1_25
    POcp1_35 = POcp1_33+RLcp1_35
    ORcp1_25 = -OMcp1_13*RLcp1_35
    ORcp1_35 = OMcp1_13*RLcp1_25
    VIcp1_25 = ORcp1_23+ORcp1_25
    VIcp1_35 = VIcp1_33+ORcp1_35
    ACcp1_25 = ACcp1_23-OPcp1_13*RLcp1_35-OMcp1_13*ORcp1_35
    ACcp1_35 = ACcp1_33+OPcp1_13*RLcp1_25+OMcp1_13*ORcp1_25
    OPcp1_25 = qdd[5]*ROcp1_53-qd[5]*OMcp1_13*ROcp1_63
    OPcp1_35 = qd[5]*OMcp1_13*ROcp1_53+qdd[5]*ROcp1_63
    OMcp1_25 = qd[5]*ROcp1_53
    OMcp1_35 = qd[5]*ROcp1_63
    ROcp1_25 = -ROcp1_83*S5
    ROcp1_35 = -ROcp1_93*S5
    ROcp1_85 = ROcp1_83*C5
    ROcp1_95 = ROcp1_93*C5
    PxF1[1] = 0
    PxF1[2] = POcp1_25
    PxF1[3] = POcp1_35
    RxF1[1,1] = C5
    RxF1[1,2] = ROcp1_25
    RxF1[1,3] = ROcp1_35
    RxF1[2,1] = 0
    RxF1[2,2] = ROcp1_53
    RxF1[2,3] = ROcp1_63
    RxF1[3,1] = S5
    RxF1[3,2] = ROcp1_85
    RxF1[3,3] = ROcp1_95
    VxF1[1] = 0
    VxF1[2] = VIcp1_25
    VxF1[3] = VIcp1_35
    OMxF1[1] = OMcp1_13
    OMxF1[2] = OMcp1_25
    OMxF1[3] = OMcp1_35
    AxF1[1] = 0
    AxF1[2] = ACcp1_25
    AxF1[3] = ACcp1_35
    OMPxF1[1] = OPcp1_13
    OMPxF1[2] = OPcp1_25
    OMPxF1[3] = OPcp1_35

# Sensor Forces Computation

    SWr1 = s.user_ExtForces(PxF1,RxF1,VxF1,OMxF1,AxF1,OMPxF1,s,tsim,1)

# Sensor Dynamics: forces projection on body-fixed frames

    xfrc11 = SWr1[1]*C5+ROcp1_25*SWr1[2]+ROcp1_35*SWr1[3]
    xfrc21 = ROcp1_53*SWr1[2]+ROcp1_63*SWr1[3]
    xfrc31 = SWr1[1]*S5+ROcp1_85*SWr1[2]+ROcp1_95*SWr1[3]
    xtrq11 = SWr1[4]*C5+ROcp1_25*SWr1[5]+ROcp1_35*SWr1[6]
    xtrq21 = ROcp1_53*SWr1[5]+ROcp1_63*SWr1[6]
    xtrq31 = SWr1[4]*S5+ROcp1_85*SWr1[5]+ROcp1_95*SWr1[6]
    frc[1,5] = s.frc[1,5]+xfrc11
    frc[2,5] = s.frc[2,5]+xfrc21
    frc[3,5] = s.frc[3,5]+xfrc31
    trq[1,5] = s.trq[1,5]+xtrq11+SWr1[8]*xfrc31-SWr1[9]*xfrc21
    trq[2,5] = s.trq[2,5]+xtrq21+SWr1[9]*xfrc11-SWr1[7]*xfrc31
    trq[3,5] = s.trq[3,5]+xtrq31+SWr1[7]*xfrc21-SWr1[8]*xfrc11

# Number of continuation lines = 0
