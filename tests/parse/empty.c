void cons_hJ(double *h,double **Jac, MBSdataStruct *s, double tsim) 
{ 
} 
