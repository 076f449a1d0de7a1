/* The data of a model as generated functions reach it: the members of
   MBsysC's structure that a simulation needs, under the same names. All arrays
   count from 1. */
#ifndef mbs_data_h
#define mbs_data_h

typedef struct MbsData
{
    int njoint, npt;
    /* Numbers of independent, driven and dependent joints, and of independent
       rows of constraints, with how many there are. */
    int nqu, nqc, nqv, nhu;
    int *qu, *qc, *qv, *hu;
    double *q, *qd, *qdd;
    /* Parameters: points, centres of mass, masses, inertias, gravity, rods. */
    double *dpt[4], *l[4], *m, *In[10], g[4], *lrod;
    /* Loads of bodies and joints. */
    double *frc[4], *trq[4], *Qq;
    /* Rows of constraints of loops, and of the user. */
    int Nloopc, Nuserc;
    double NRerr;
    int Nlink, Nlink3D, Nxfrc;
    double *Fl, *Z, *Zd;
    /* Of the user's laws: lengths that links began with, and the places of
       external forces, whose element 0 tells that they are known. */
    double *Z0, **P0;
    /* The point of each external force, and what its law returns. */
    int *xfidpt;
    double **SWr;
    double tsim;
} MbsData;

#endif
