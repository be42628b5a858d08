//{ states
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    return polynomial_at($TUNED_FIRSTu);
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    real v = polynomial_at($TUNED_FIRSTu);
    int32_t i;
    for (i = 0; i < $NAME_STATE_LAWS; i++) {
        v = v - (state->z[i] + increment(&K(state_laws)[i], state->z[i], u - state->voltage));
    }
    return v;
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    real z[$NAME_STATE_LAWS], z_carry[$NAME_STATE_LAWS];
    const real du = u - state->voltage;
    int32_t i;
    real out = polynomial_at($TUNED_FIRSTu);
    for (i = 0; i < $NAME_STATE_LAWS; i++) {
        z[i] = state->z[i];
        z_carry[i] = state->z_carry[i];
        accumulate(&z[i], &z_carry[i], increment(&K(state_laws)[i], state->z[i], du));
        out = out - z[i];
    }
    if (!is_in_range(out)) {
        return false;
    }
    for (i = 0; i < $NAME_STATE_LAWS; i++) {
        state->z[i] = z[i];
        state->z_carry[i] = z_carry[i];
    }
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    int32_t i;
    (void)u;
    for (i = 0; i < $NAME_STATE_LAWS; i++) {
        state->z[i] = R(0);
        state->z_carry[i] = R(0);
    }
}

//}
