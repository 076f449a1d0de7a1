function [sens] = sensor(s,tsim,usrfun,isens)
switch isens
case 1
  sens.P(1) = s.q(1);
