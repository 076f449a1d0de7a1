def invdyna(phi,s,tsim):
    Qq = phi
    Qq[0] = s.q[1]
    Qq[1] = s.dpt[3,0]
    Qq[2] = s.q[1000001]
    Qq[3] = s.q[99999999999999999999]
    Qq[4] = s.q[1,2][3]
