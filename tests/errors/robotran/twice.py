def invdyna(phi,s,tsim):
    Qq = phi
    A1 = s.q[1]*s.q[2]
    A2 = A1*A1
    A1 = s.q[2]
    Qq[1] = A2+A1
