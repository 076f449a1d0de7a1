/* What MBsysC gives to a file of equations, as far as they read it. */
#ifndef STUB
#define STUB
#include <math.h>
typedef struct MbsData {
    double *q, *qd, *qdd, *m, *g, *lrod, *c, *Qq, *h, *Jdqd, *Flink, *Z, *Zd;
    double **dpt, **l, **In, **frc, **trq, **M, **Jac;
    double tsim;
    int flag, flag_stop;
} MbsData, MBSdataStruct;
typedef struct MbsSensor {
    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4], J[7][EXTENT];
} MbsSensor, MBSsensorStruct;
double *user_ExtForces(double P[4], double R[4][4], double V[4], double OM[4],
                       double A[4], double OMP[4], MbsData *s, double tsim, int number);
double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int number);
double *user_JointForces(MbsData *s, double tsim);
void user_DrivenJoints(MbsData *s, double tsim);
#define user_call_ExtForces user_ExtForces
#define user_call_LinkForces user_LinkForces
#define user_call_JointForces user_JointForces
#define user_call_DrivenJoints user_DrivenJoints
#define mbs_msg(...) ((void)0)
#define MBS_INFO_SUCCESS 0
#endif
