function [M,c] = dirdyna(s,tsim,usrfun)
 M = zeros(2,2);
 c = zeros(2,1);
  A = s.q(1)*s.q(2);
  M(1,1) = A;
