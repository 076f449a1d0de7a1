function [Qq] = invdyna(s,tsim,usrfun)
  A = s.dpt(3,1)*s.dpt(2);
  Qq(1) = A;
  q = A;
  Qq(2) = s.q(1)*dpt;
