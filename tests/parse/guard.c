#include "mbs_data.h"
void mbs_cons_jdqd(double *Jdqd, MbsData *s, double tsim)
{
mbs_msg("Your symbolic files seem obsolete (no constraints). Please regenerate them.") ;
s->flag_stop = 1;
return;
}
