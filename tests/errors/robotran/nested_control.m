function [sens] = sensor(s,tsim,usrfun,isens)
switch isens
case 1
  if s.q(1) > 0
    sens.P(1) = s.q(1)*s.q(2);
  end
end
switch mode
case 1
  sens.P(1) = s.q(1);
end
