import numpy as np
def gensensor(sens, s, isens):
  q = s.q
  C1 = np.cos(q[1])
  if(isens==1):
    sens.P[1] = C1
  elif(isens==2):
    sens.P[2] = C1*C1
  else:
    sens.P[3] = C1
