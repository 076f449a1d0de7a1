#
#	A quarter of a car with double wishbones, written for robovec
#	in the style of Robotran's files. The model: README.md
#
#	==> Project name : suspension
#
#	==> Number of joints : 5
#
#	==> Function : F 8 : Constraints Vector (h) and Jacobian Matrix (Jac)
#

from math import sin, cos

def cons_hJ(h, Jac, s):
    q = s.q

# Trigonometric functions

    C2 = cos(q[2])
    S2 = sin(q[2])
    C3 = cos(q[3])
    S3 = sin(q[3])
    C4 = cos(q[4])
    S4 = sin(q[4])

# Constraints and Constraints Jacobian

    ROlp1_82 = -S2
    RLlp1_23 = s.dpt[2,4]*C2
    RLlp1_33 = s.dpt[2,4]*S2
    POlp1_23 = s.dpt[2,1]+RLlp1_23
    POlp1_33 = s.dpt[3,1]+RLlp1_33
    JTlp1_23_2 = -RLlp1_33
    ROlp1_53 = C2*C3+ROlp1_82*S3
    ROlp1_63 = C3*S2+C2*S3
    ROlp1_83 = ROlp1_82*C3-C2*S3
    ROlp1_93 = C2*C3-S2*S3
    RLlp1_2p = ROlp1_53*s.dpt[2,6]+ROlp1_83*s.dpt[3,6]
    RLlp1_3p = ROlp1_63*s.dpt[2,6]+ROlp1_93*s.dpt[3,6]
    POlp1_2p = POlp1_23+RLlp1_2p
    POlp1_3p = POlp1_33+RLlp1_3p
    JTlp1_2p_2 = JTlp1_23_2-RLlp1_3p
    JTlp1_3p_2 = RLlp1_23+RLlp1_2p
    JTlp1_2p_3 = -RLlp1_3p
    RLlp2_2p = s.dpt[2,8]*C4
    RLlp2_3p = s.dpt[2,8]*S4
    POlp2_2p = s.dpt[2,2]+RLlp2_2p
    POlp2_3p = s.dpt[3,2]+RLlp2_3p
    JTlp2_2p_4 = -RLlp2_3p
    h[1] = POlp1_2p-POlp2_2p
    h[2] = POlp1_3p-POlp2_3p
    Jac[1,2] = JTlp1_2p_2
    Jac[1,3] = JTlp1_2p_3
    Jac[1,4] = -JTlp2_2p_4
    Jac[2,2] = JTlp1_3p_2
    Jac[2,3] = RLlp1_2p
    Jac[2,4] = -RLlp2_2p

# Number of continuation lines = 0
