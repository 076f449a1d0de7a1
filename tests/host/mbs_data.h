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
    /* Multipliers of the independent rows, and forces of driven joints and of
       actuators. */
    double *lambda, *Qc, *Qa;
    double NRerr;
    int Nlink, Nlink3D, Nxfrc;
    double *Fl, *Z, *Zd;
    /* Of the user's laws: joints that constraints determine, values that these
       began with, forces beside the laws, lengths that links began with, and the places of
       external forces, whose element 0 tells that they are known. */
    int *bound, is_bound;
    double *h0, *Qx, *Z0, **P0;
    /* The point of each external force, and what its law returns. */
    int *xfidpt;
    double **SWr;
    double tsim;
} MbsData;

#endif
