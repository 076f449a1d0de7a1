%	ROBOTRAN - Version 6.6 (build : february 22, 2008)
%	==> Generation Date : Mon Nov 30 14:42:10 2020
%	==> Project name : Université 
%	==> Number of joints : 4
%	==> All Parameter Symbols included
%	==> Function : F 2 : Inverse Dynamics : RNEA
%	==> Flops complexity : 6
function [Qq] = invdyna(s,tsim,usrfun)

 Qq = zeros(4,1);

q = s.q; 
qd = s.qd; 

% ===== BEGIN task 0 ===== 

  C4 = cos(q(4)); S4 = sin(q(4));
%{
  C5 = nothing of this is read
%}
  A1 = C4*(q(1)+... a comment behind the dots
 q(2))-S4*...
 q(3);
  Qq(1) = A1;
  Qq(3) = -A1 + s.m(2)

% ====== END Task 0 ====== 
