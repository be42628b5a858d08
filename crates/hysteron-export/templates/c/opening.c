$DESCRIPTION
#include <math.h>
#include <string.h>

#include "$name.h"

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: the sums of small increments are compensated, which it takes away"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

typedef $name_real real;

//{ state_law
//{ !states|!tunable
//+ type of a state
//}
typedef $name_state_law state_law;

//}
$TABLES
/* Neither infinite nor NaN. */
static bool is_finite(real x)
{
    return F(fabs)(x) <= R(MAX);
}

/* Whether the dynamics can be fed with v: from there on they stay within the range of the number type. */
static bool is_in_range(real v)
{
    return F(fabs)(v) <= R(LARGEST);
}

