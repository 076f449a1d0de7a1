%
%	A quarter of a car with double wishbones, written for robovec
%	in the style of Robotran's files. The model: README.md
%
%	==> Project name : suspension
%
%	==> Number of joints : 5
%
%	==> Function : F18 : Constraints Quadratic Terms (Jdqd)
%

function [Jdqd] = cons_jdqd(s,tsim,usrfun)

 Jdqd = zeros(2,1);

q = s.q;
qd = s.qd;
qdd = s.qdd;
frc = s.frc;
trq = s.trq;

% ===== BEGIN task 0 =====

% Trigonometric functions

  C2 = cos(q(2));
  S2 = sin(q(2));
  C3 = cos(q(3));
  S3 = sin(q(3));
  C4 = cos(q(4));
  S4 = sin(q(4));

% Constraints Quadratic Terms

  ROjdqd1_82 = -S2;
  RLjdqd1_23 = s.dpt(2,4)*C2;
  RLjdqd1_33 = s.dpt(2,4)*S2;
  ORjdqd1_23 = -qd(2)*RLjdqd1_33;
  ORjdqd1_33 = qd(2)*RLjdqd1_23;
  ACjdqd1_23 = -qd(2)*ORjdqd1_33;
  ACjdqd1_33 = qd(2)*ORjdqd1_23;
  OMjdqd1_13 = qd(2)+qd(3);
  ROjdqd1_53 = C2*C3+ROjdqd1_82*S3;
  ROjdqd1_63 = C3*S2+C2*S3;
  ROjdqd1_83 = ROjdqd1_82*C3-C2*S3;
  ROjdqd1_93 = C2*C3-S2*S3;
  RLjdqd1_2p = ROjdqd1_53*s.dpt(2,6)+ROjdqd1_83*s.dpt(3,6);
  RLjdqd1_3p = ROjdqd1_63*s.dpt(2,6)+ROjdqd1_93*s.dpt(3,6);
  ORjdqd1_2p = -OMjdqd1_13*RLjdqd1_3p;
  ORjdqd1_3p = OMjdqd1_13*RLjdqd1_2p;
  ACjdqd1_2p = ACjdqd1_23-OMjdqd1_13*ORjdqd1_3p;
  ACjdqd1_3p = ACjdqd1_33+OMjdqd1_13*ORjdqd1_2p;
  RLjdqd2_2p = s.dpt(2,8)*C4;
  RLjdqd2_3p = s.dpt(2,8)*S4;
  ORjdqd2_2p = -qd(4)*RLjdqd2_3p;
  ORjdqd2_3p = qd(4)*RLjdqd2_2p;
  ACjdqd2_2p = -qd(4)*ORjdqd2_3p;
  ACjdqd2_3p = qd(4)*ORjdqd2_2p;
  Jdqd(1) = ACjdqd1_2p-ACjdqd2_2p;
  Jdqd(2) = ACjdqd1_3p-ACjdqd2_3p;

% ====== END Task 0 ======
