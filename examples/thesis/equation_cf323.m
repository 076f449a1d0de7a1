% The equation whose tree figures 2.1 to 2.11 of the thesis draw: the third
% component of a torque, with a leading minus that atomising turns into a
% subtraction from zero.

function [CF] = equation_cf323(s,FA123,FA223,OM123,OM223,OA323)

  CF323 = -FA123*s.l(2,23)+FA223*s.l(1,23)-s.In(1,23)*OM123*OM223...
 +s.In(5,23)*OM123*OM223+s.In(9,23)*OA323;

  CF(3,23) = CF323;
