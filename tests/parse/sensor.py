def sensor(sens, s, isens):
  q = s.q
  C1 = cos(q[1])
  if (isens == 1): 

    ROcp1_1 = C1*q[2]
# a comment in the first column
    sens.P[1] = ROcp1_1

  if (isens == 2):
    sens.P[2] = C1
    sens.R[1,1] = (1.0)
