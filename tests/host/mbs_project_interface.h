/* What the equations and the user give to a simulation. */
#ifndef mbs_project_interface_h
#define mbs_project_interface_h

#include "mbs_data.h"

void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim);
void mbs_link(double **frc, double **trq, double *Flink, double *Z, double *Zd, MbsData *s, double tsim);
void mbs_extforces(double **frc, double **trq, MbsData *s, double tsim);
int mbs_accelred(MbsData *s, double tsim);
int mbs_invdynared(MbsData *s, double tsim);

void user_DrivenJoints(MbsData *s, double tsim);
void user_cons_hJ(double *h, double **Jac, MbsData *s, double tsim);
void user_cons_jdqd(double *jdqd, MbsData *s, double tsim);
double *user_JointForces(MbsData *s, double tsim);
double user_LinkForces(double Z, double Zd, MbsData *s, double tsim, int ilnk);
double *user_ExtForces(double PxF[4], double RxF[4][4], double VxF[4], double OMxF[4],
                       double AxF[4], double OMPxF[4], MbsData *s, double tsim, int ixF);

#endif
