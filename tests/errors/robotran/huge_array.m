function [M] = dirdyna(s,tsim,usrfun)
  M(1,1000000) = s.q(1);
  M(1000000,1) = s.q(2)*s.q(1);
