%	ROBOTRAN - Version 6.6 (build : february 22, 2008)
function [Qq] = invdyna(s,tsim,usrfun)
% ===== BEGIN task 0 =====
  Qq(1) = s.q(1)*s.q(2);
