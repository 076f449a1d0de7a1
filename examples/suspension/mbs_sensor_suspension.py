#
#	A quarter of a car with double wishbones, written for robovec
#	in the style of Robotran's files. The model: README.md
#
#	==> Project name : suspension
#
#	==> Number of joints : 5
#
#	==> Function : F 6 : Sensors Kinematical Informations (sens)
#

from math import sin, cos

def sensor(sens, s, isens):
    q = s.q
    qd = s.qd
    qdd = s.qdd

# Trigonometric functions

    C2 = cos(q[2])
    S2 = sin(q[2])
    C3 = cos(q[3])
    S3 = sin(q[3])
    C5 = cos(q[5])
    S5 = sin(q[5])

# Sensor Kinematics


    if (isens == 1):

        POcp1_32 = q[1]+s.dpt[3,1]
        ROcp1_82 = -S2
        RLcp1_23 = s.dpt[2,4]*C2
        RLcp1_33 = s.dpt[2,4]*S2
        POcp1_23 = s.dpt[2,1]+RLcp1_23
        POcp1_33 = POcp1_32+RLcp1_33
        JTcp1_23_2 = -RLcp1_33
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
        JTcp1_25_2 = JTcp1_23_2-RLcp1_35
        JTcp1_35_2 = RLcp1_23+RLcp1_25
        JTcp1_25_3 = -RLcp1_35
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
        sens.P[1] = 0
        sens.P[2] = POcp1_25
        sens.P[3] = POcp1_35
        sens.R[1,1] = C5
        sens.R[1,2] = ROcp1_25
        sens.R[1,3] = ROcp1_35
        sens.R[2,2] = ROcp1_53
        sens.R[2,3] = ROcp1_63
        sens.R[3,1] = S5
        sens.R[3,2] = ROcp1_85
        sens.R[3,3] = ROcp1_95
        sens.V[1] = 0
        sens.V[2] = VIcp1_25
        sens.V[3] = VIcp1_35
        sens.OM[1] = OMcp1_13
        sens.OM[2] = OMcp1_25
        sens.OM[3] = OMcp1_35
        sens.A[1] = 0
        sens.A[2] = ACcp1_25
        sens.A[3] = ACcp1_35
        sens.OMP[1] = OPcp1_13
        sens.OMP[2] = OPcp1_25
        sens.OMP[3] = OPcp1_35
        sens.J[2,2] = JTcp1_25_2
        sens.J[2,3] = JTcp1_25_3
        sens.J[3,1] = (1.0)
        sens.J[3,2] = JTcp1_35_2
        sens.J[3,3] = RLcp1_25
        sens.J[4,2] = (1.0)
        sens.J[4,3] = (1.0)
        sens.J[5,5] = ROcp1_53
        sens.J[6,5] = ROcp1_63

    if (isens == 2):

        sens.P[1] = 0
        sens.P[2] = 0
        sens.P[3] = q[1]
        sens.R[1,1] = (1.0)
        sens.R[2,2] = (1.0)
        sens.R[3,3] = (1.0)
        sens.V[1] = 0
        sens.V[2] = 0
        sens.V[3] = qd[1]
        sens.OM[1] = 0
        sens.OM[2] = 0
        sens.OM[3] = 0
        sens.A[1] = 0
        sens.A[2] = 0
        sens.A[3] = qdd[1]
        sens.OMP[1] = 0
        sens.OMP[2] = 0
        sens.OMP[3] = 0
        sens.J[3,1] = (1.0)

# Number of continuation lines = 0
