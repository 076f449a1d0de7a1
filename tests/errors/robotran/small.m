function [Qq] = invdyna(s,tsim,usrfun)
Qq = zeros(1,1);
q = s.q;
Qq(1) = 1e-400*q(1);
% Number of continuation lines = 0
