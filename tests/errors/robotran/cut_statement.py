def invdyna(phi,s,tsim):
    Qq = phi
    A1 = s.q[1]*(s.q[2]+
