// Local arrays with first values, and copies of the structure's pointers, as
// the generator of 2025 writes them; a control character () in a comment.
int mbs_invdynared(double *Qa, MbsData *s, double tsim)
{
double *q = s->q;
double *qd;
double *Qc = s->Qc;
double PxF1[4] = {3.0, 0.0, 1.5, 0.0};
double RxF1[4][4] = {{9.0, 3.0, 3.0, 3.0}, {3.0, 1.0, 0.0, 0.0}, {3.0, 0.0, 1.0, 0.25}};
double VxF1[4] = {0};
qd = s->qd;
PxF1[1] = q[1]*q[1];
Qa[1] = PxF1[1]*PxF1[2]+PxF1[3]+Qc[1];
Qa[2] = RxF1[1][1]*qd[2]+RxF1[2][3]+RxF1[3][3]+VxF1[1];
return 0;
}
