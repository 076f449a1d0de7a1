//	==> Number of joints : 2
// A sign inside the parentheses belongs to the number; before them it is an
// operation, as Robotran writes it.

void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
double A, B, D;
A = (-2.0)*q[1];
B = -(2.0)*q[1]+(-2.0*q[2]);
D = sin(-3.0)-( - 1e-3 )/(-q[1]);
Qq[1] = (-1.0);
Qq[2] = A+B*D-(-0.0);
}
