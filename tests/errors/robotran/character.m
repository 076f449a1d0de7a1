function [Qq] = invdyna(s,tsim,usrfun)
  Qq(1) = s.q(1)·s.q(2);
  Qq(2) = s.q(1) $ 2;
