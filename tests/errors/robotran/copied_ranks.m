function [frc,trq] = extforces(s,tsim,usrfun)
frc = s.frc;
  frc(1,2) = s.q(1);
  trq(1,1) = frc(2,2)*s.frc(3);
