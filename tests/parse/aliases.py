from numpy import zeros

def extforces(frc, trq, s, tsim):
    q = s.q
    frc = s.frc
    PxF1 = zeros(4)
    RxF1 = zeros((4, 4))
    PxF1[1] = q[1]
    RxF1[2,2] = q[1]*q[2]
    SWr1 = s.user_ExtForces(PxF1,RxF1,s,tsim,1)
    frc[1,2] = s.frc[1,2]+SWr1[1]
    frc[2,2] = frc[1,2]*RxF1[2,2]
    trq[1,2] = RxF1[1,1]
