%
%	A quarter of a car with double wishbones, written for robovec
%	in the style of Robotran's files. The model: README.md
%
%	==> Project name : suspension
%
%	==> Number of joints : 5
%
%	==> Function : F 1 : Direct Dynamics
%

function [M,c] = dirdyna(s,tsim,usrfun)

 M = zeros(5,5);
 c = zeros(5,1);

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
  C5 = cos(q(5));
  S5 = sin(q(5));

% Forward Kinematics

  AF31 = -s.g(3);
  BS52 = -qd(2)*qd(2);
  AF22 = AF31*S2;
  AF32 = AF31*C2;
  OM13 = qd(2)+qd(3);
  BS53 = -OM13*OM13;
  BS93 = -OM13*OM13;
  AF23 = AF22*C3+BS52*s.dpt(2,4)*C3+AF32*S3;
  AF33 = AF32*C3-AF22*S3-BS52*s.dpt(2,4)*S3;
  AM23_1 = C3*S2+C2*S3;
  AM33_1 = C2*C3-S2*S3;
  AM23_2 = s.dpt(2,4)*S3;
  AM33_2 = s.dpt(2,4)*C3;
  BS54 = -qd(4)*qd(4);
  AF24 = AF31*S4;
  AF34 = AF31*C4;
  OM15 = OM13*C5;
  OM35 = OM13*S5;
  OA15 = -qd(5)*OM13*S5;
  OA35 = qd(5)*OM13*C5;
  AF15 = -AF33*S5-BS93*s.dpt(3,7)*S5;
  AF25 = AF23+BS53*s.dpt(2,7);
  AF35 = AF33*C5+BS93*s.dpt(3,7)*C5;
  AM15_1 = -AM33_1*S5;
  AM35_1 = AM33_1*C5;
  AM15_2 = -AM33_2*S5-s.dpt(2,7)*S5;
  AM25_2 = AM23_2-s.dpt(3,7);
  AM35_2 = AM33_2*C5+s.dpt(2,7)*C5;
  AM15_3 = -s.dpt(2,7)*S5;
  AM25_3 = -s.dpt(3,7);
  AM35_3 = s.dpt(2,7)*C5;

% Backward Dynamics

  FA15 = AF15*s.m(5)-s.frc(1,5);
  FA25 = AF25*s.m(5)-s.frc(2,5);
  FA35 = AF35*s.m(5)-s.frc(3,5);
  CF15 = s.In(1,5)*OA15+qd(5)*s.In(9,5)*OM35-s.trq(1,5)-qd(5)*s.In(5,5)*OM35;
  CF25 = s.In(1,5)*OM15*OM35-s.trq(2,5)-s.In(9,5)*OM15*OM35;
  CF35 = s.In(9,5)*OA35+qd(5)*s.In(5,5)*OM15-s.trq(3,5)-qd(5)*s.In(1,5)*OM15;
  FB15_1 = AM15_1*s.m(5);
  FB25_1 = AM23_1*s.m(5);
  FB35_1 = AM35_1*s.m(5);
  FB15_2 = AM15_2*s.m(5);
  FB25_2 = AM25_2*s.m(5);
  FB35_2 = AM35_2*s.m(5);
  CM15_2 = s.In(1,5)*C5;
  CM35_2 = s.In(9,5)*S5;
  FB15_3 = AM15_3*s.m(5);
  FB25_3 = AM25_3*s.m(5);
  FB35_3 = AM35_3*s.m(5);
  CM15_3 = s.In(1,5)*C5;
  CM35_3 = s.In(9,5)*S5;
  FA24 = AF24*s.m(4)+BS54*s.l(2,4)*s.m(4)-s.frc(2,4);
  FA34 = AF34*s.m(4)-s.frc(3,4);
  CF14 = FA34*s.l(2,4)-s.trq(1,4);
  FB24_1 = s.m(4)*S4;
  FB34_1 = s.m(4)*C4;
  CM14_1 = FB34_1*s.l(2,4);
  FB34_4 = s.l(2,4)*s.m(4);
  CM14_4 = FB34_4*s.l(2,4)+s.In(1,4);
  FA23 = AF23*s.m(3)+BS53*s.l(2,3)*s.m(3)-s.frc(2,3);
  FA33 = AF33*s.m(3)+BS93*s.l(3,3)*s.m(3)-s.frc(3,3);
  FF23 = FA23+FA25;
  FF33 = FA33+FA35*C5-FA15*S5;
  CF13 = FA33*s.l(2,3)+CF15*C5+CF35*S5+FA35*s.dpt(2,7)*C5-s.trq(1,3)-FA23*s.l(3,3)-FA15*s.dpt(2,7)*...
 S5-FA25*s.dpt(3,7);
  FB23_1 = AM23_1*s.m(3);
  FB33_1 = AM33_1*s.m(3);
  FM23_1 = FB23_1+FB25_1;
  FM33_1 = FB33_1+FB35_1*C5-FB15_1*S5;
  CM13_1 = FB33_1*s.l(2,3)+FB35_1*s.dpt(2,7)*C5-FB23_1*s.l(3,3)-FB15_1*s.dpt(2,7)*S5-FB25_1*...
 s.dpt(3,7);
  FB23_2 = AM23_2*s.m(3)-s.l(3,3)*s.m(3);
  FB33_2 = AM33_2*s.m(3)+s.l(2,3)*s.m(3);
  FM23_2 = FB23_2+FB25_2;
  FM33_2 = FB33_2+FB35_2*C5-FB15_2*S5;
  CM13_2 = FB33_2*s.l(2,3)+s.In(1,3)+CM15_2*C5+CM35_2*S5+FB35_2*s.dpt(2,7)*C5-FB23_2*s.l(3,3)-...
 FB15_2*s.dpt(2,7)*S5-FB25_2*s.dpt(3,7);
  FB23_3 = -s.l(3,3)*s.m(3);
  FB33_3 = s.l(2,3)*s.m(3);
  CM13_3 = FB33_3*s.l(2,3)+s.In(1,3)+CM15_3*C5+CM35_3*S5+FB35_3*s.dpt(2,7)*C5-FB23_3*s.l(3,3)-...
 FB15_3*s.dpt(2,7)*S5-FB25_3*s.dpt(3,7);
  FA22 = AF22*s.m(2)+BS52*s.l(2,2)*s.m(2)-s.frc(2,2);
  FA32 = AF32*s.m(2)-s.frc(3,2);
  FF22 = FA22+FF23*C3-FF33*S3;
  FF32 = FA32+FF23*S3+FF33*C3;
  CF12 = FA32*s.l(2,2)+CF13+FF23*s.dpt(2,4)*S3+FF33*s.dpt(2,4)*C3-s.trq(1,2);
  FB22_1 = s.m(2)*S2;
  FB32_1 = s.m(2)*C2;
  FM22_1 = FB22_1+FM23_1*C3-FM33_1*S3;
  FM32_1 = FB32_1+FM23_1*S3+FM33_1*C3;
  CM12_1 = FB32_1*s.l(2,2)+CM13_1+FM23_1*s.dpt(2,4)*S3+FM33_1*s.dpt(2,4)*C3;
  FB32_2 = s.l(2,2)*s.m(2);
  CM12_2 = FB32_2*s.l(2,2)+s.In(1,2)+CM13_2+FM23_2*s.dpt(2,4)*S3+FM33_2*s.dpt(2,4)*C3;
  FA31 = AF31*s.m(1)-s.frc(3,1);
  FF31 = FA31+FF22*S2+FF32*C2+FA24*S4+FA34*C4;
  FM31_1 = s.m(1)+FM22_1*S2+FM32_1*C2+FB24_1*S4+FB34_1*C4;

% Symbolic model output

  M(1,1) = FM31_1;
  M(1,2) = CM12_1;
  M(1,3) = CM13_1;
  M(1,4) = CM14_1;
  M(2,1) = CM12_1;
  M(2,2) = CM12_2;
  M(2,3) = CM13_2;
  M(3,1) = CM13_1;
  M(3,2) = CM13_2;
  M(3,3) = CM13_3;
  M(4,1) = CM14_1;
  M(4,4) = CM14_4;
  M(5,5) = s.In(5,5);
  c(1) = FF31;
  c(2) = CF12;
  c(3) = CF13;
  c(4) = CF14;
  c(5) = CF25;

% ====== END Task 0 ======
