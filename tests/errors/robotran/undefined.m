function [Qq] = invdyna(s,tsim,usrfun)
q = s.q;
  OM16 = q(1)*q(2);
  OM26 = OM16*OM61;
  Qq(1) = OM26+Absent;
  Qq(2) = OM16*NaN;
