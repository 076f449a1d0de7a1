def cons_hJ(h, Jac, s):
    q = s.q
    h[1] = q[1]*q[2]
    Jac[1,1] = q[2]
    Jac[1,2] = q[1]
def cons_jdqd(Jdqd, s):
    Jdqd[1] = s.qd[1]*s.qd[2]+s.qd[1]*s.qd[2]
