void link(double *Z, MbsData *s) { Z[1] = s->q[1]*s->q[1]; }
void mbs_link(double *Z, MbsData *s) { Z[1] = s->q[1]*s->q[2]; }
