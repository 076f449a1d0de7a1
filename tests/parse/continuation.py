#	MBsysTran - Release 8.1
#	==> Project name: small
#	==> Number of joints: 2
#	==> Function: F2 - Recursive Inverse Dynamics of tree-like MBS
import numpy as np
from math import sin, cos

def invdyna(phi,s,tsim):
    """A text that means nothing."""
    Qq = phi  # compatibility
    q = s.q
    C1 = np.cos(q[1]); S1 = sin(q[1])
    A1 = C1*q[2]+S1* \
	s.dpt[3,1]
    A2 = (A1 +
          S1)
    Qq[1] = A1*A2
    Qq[2] = 0

# Number of continuation lines = 1
