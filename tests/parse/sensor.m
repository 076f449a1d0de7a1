function [sens] = sensor(s,tsim,usrfun,isens)
 sens.P = zeros(3,1);
 sens.J = zeros(6,6);
q = s.q; 
  C1 = cos(q(1));
switch isens
 
% 
case 1, 
    sens.P(1) = C1;
case 2, 
    ROcp1_1 = C1*q(2);
    sens.P(2) = ROcp1_1;
    sens.J(6,2) = (1.0);
end
