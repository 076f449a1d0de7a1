% A slip in the prologue: both s.qd and qd begin as the input qd.
function [Qq] = invdyna(s,tsim,usrfun)
q = s.q;
q = s.qd;
  Qq(1) = q(2)*s.qd(3)+qd(7);
