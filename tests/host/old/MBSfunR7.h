/* The functions of a project under the names of generator 6.6. */
#ifndef MBSfun_h
#define MBSfun_h

#include "MBSdataStructR7.h"
#include "mbs_project_interface.h"

void dirdyna(double **M, double *c, MBSdataStruct *s, double tsim);
void cons_hJ(double *h, double **Jac, MBSdataStruct *s, double tsim);
void cons_jdqd(double *Jdqd, MBSdataStruct *s, double tsim);
void link(double **frc, double **trq, double *Flnk, double *Z, double *Zd, MBSdataStruct *s, double tsim);
void extforces(double **frc, double **trq, MBSdataStruct *s, double tsim);
int accelred(double *qddu, MBSdataStruct *s, double tsim);

#endif
