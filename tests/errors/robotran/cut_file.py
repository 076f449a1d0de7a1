#	MBsysTran - Release 8.1
def invdyna(phi,s,tsim):
    Qq = phi
    Qq[1] = s.q[1]*s.q[2]
