#ifdef HUMANOID_RAIL_AVX2
#define FILTER_KERNEL filter_by_avx2
#include "filter_kernel.inc"
#endif
