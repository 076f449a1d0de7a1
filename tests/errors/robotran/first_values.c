void mbs_invdyna(double *Qq, MbsData *s, double tsim)
{
double A[2][3] = {1.0, 2.0, 3.0};
double B[2] = {1.0, 2.0, 3.0};
double C[3] = {{1.0}, 2.0};
double D[2][3] = {1.0, {2.0}};
double E[2][3] = {{1.0}, {2.0}, {3.0}};
Qq[1] = A[1][1]+B[1]+C[1]+D[1][1]+E[1][1];
}
