#define FILTER_KERNEL filter_portably
#include "filter_kernel.inc"
