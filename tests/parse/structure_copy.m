% What is written to the structure s stays in the function.
function [frc,trq] = extforces(s,tsim,usrfun)
q = s.q;
frc = s.frc;
  PxF1(1) = q(1)*q(2);
  SWr1 = usrfun.fext(PxF1,s,tsim,1);
  frc(2,2) = q(2)*q(2);
  s.frc(1,2) = s.frc(1,2)+SWr1(1);
  T1 = q(1)+q(2);
  frc(1,2) = s.frc(1,2)+T1;
  SWr2 = usrfun.fext(PxF1,s,tsim,2);
  trq(1,1) = T1*q(1);
