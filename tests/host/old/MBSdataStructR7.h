/* The host's data under the name of generator 6.6. */
#ifndef MBSdataStruct_h
#define MBSdataStruct_h

#include "mbs_data.h"

typedef struct MbsData MBSdataStruct;

#endif
