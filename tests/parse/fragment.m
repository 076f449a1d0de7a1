% Equations without a function around them.
S1 = sin(q(1));
A = S1*q(2);
B(1) = A + A;
