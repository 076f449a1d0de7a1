% In Matlab frc is a copy: s.frc keeps its first values.
function [frc,trq] = extforces(s,tsim,usrfun)
 frc = zeros(3,2);
 trq = zeros(3,2);
q = s.q;
frc = s.frc;
  PxF1(1) = q(1);
  PxF1(2) = 0;
  PxF1(3) = q(1)*q(2);
  SWr1 = usrfun.fext(PxF1,s,tsim,1);
  frc(1,2) = s.frc(1,2)+SWr1(1);
  frc(2,2) = frc(2,2)+s.frc(1,2)*PxF1(3);
  frc(3,2) = frc(1,2)*SWr1(9);
  trq(1,2) = trq(1,1)+q(1);
