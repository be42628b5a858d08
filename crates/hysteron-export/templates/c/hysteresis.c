//+ shared functions
/* The polynomial l[u]. */
static real polynomial_at($TUNED_AS_ARGUMENT_FIRSTreal u)
{
//{ polynomial
    real sum = R(0);
    int32_t i;
    for (i = $N_POLYNOMIAL - 1; i >= 0; i--) {
        sum = (sum + K(polynomial)[i]) * u;
    }
    return sum;
//}
//{ !polynomial
//{ tunable
    (void)state;
//}
    (void)u;
    return R(0);
//}
}

//+ law of a branch
//+ operators
//{ memoryless
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    return polynomial_at($TUNED_FIRSTu);
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    (void)state;
    return polynomial_at($TUNED_FIRSTu);
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    const real out = polynomial_at($TUNED_FIRSTu);
    if (!is_in_range(out)) {
        return false;
    }
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    (void)state;
    (void)u;
}

//}
