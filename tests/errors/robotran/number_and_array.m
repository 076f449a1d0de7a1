function [Qq] = invdyna(s,tsim,q)
  Qq(1) = s.q(1)*q;
