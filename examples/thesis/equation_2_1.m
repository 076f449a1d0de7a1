% Equation (2.1) of the thesis: eight equations that fall into two groups of
% independent ones (vectors), once the sines and cosines are known.

function [AF,OM] = equation_2_1(s,tsim,usrfun)

q = s.q;
qd = s.qd;

  C4 = cos(q(4));
  S4 = sin(q(4));
  C5 = cos(q(5));
  S5 = sin(q(5));
  C6 = cos(q(6));
  S6 = sin(q(6));

  AF24 = -s.g(3)*S4;
  AF34 = -s.g(3)*C4;
  OM15 = qd(4)*C5;
  OM35 = qd(4)*S5;
  AF15 = -AF34*S5;
  AF35 = AF34*C5;
  OM16 = qd(5)*S6+OM15*C6;
  OM26 = qd(5)*C6-OM15*S6;

  AF(2,4) = AF24;
  AF(1,5) = AF15;
  AF(3,5) = AF35;
  OM(3,5) = OM35;
  OM(1,6) = OM16;
  OM(2,6) = OM26;
