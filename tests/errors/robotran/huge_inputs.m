function [M] = dirdyna(s,tsim,usrfun)
  a = s.a;
  b = s.b;
  M(1,1) = a(1000000)*a(2);
  M(2,1) = b(1)*b(900000);
