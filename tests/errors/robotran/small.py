def invdyna(phi,s,tsim):
    Qq = phi
    q = s.q
    Qq[1] = 1e-400*q[1]
# Number of continuation lines = 0
