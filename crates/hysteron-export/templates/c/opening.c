$DESCRIPTION
#include <math.h>

#include "$name.h"

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: the sums of small increments are compensated, which it takes away"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

typedef $name_real real;

$TABLES
