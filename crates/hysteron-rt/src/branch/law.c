//{ branch
//{ !own_output
/* Output of a state at u. */
static real branch_output(real y, real u)
{
    (void)u;
    return y;
}

//}
//{ !own_virgin
/* A state, virgin at u. */
static real branch_virgin(real u)
{
    (void)u;
    return R(0);
}

//}
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    const real state_there = branch_virgin(u);
    real sum = R(0);
    int32_t i;
    for (i = 0; i < $NAME_STATES; i++) {
        sum = sum + K(weight)[i] * branch_output(state_there, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    real own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
    int32_t i;
    for (i = 0; i < $NAME_STATES; i++) {
        const real y = state->y[i] + (own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    real y[$NAME_STATES], y_carry[$NAME_STATES], own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
    int32_t i;
    real out = polynomial_at($TUNED_FIRSTu);
    for (i = 0; i < $NAME_STATES; i++) {
        y[i] = state->y[i];
        y_carry[i] = state->y_carry[i];
        accumulate(&y[i], &y_carry[i], own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y[i], u);
    }
    out = out + sum;
    if (!is_in_range(out)) {
        return false;
    }
    for (i = 0; i < $NAME_STATES; i++) {
        state->y[i] = y[i];
        state->y_carry[i] = y_carry[i];
    }
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    int32_t i;
    for (i = 0; i < $NAME_STATES; i++) {
        state->y[i] = branch_virgin(u);
        state->y_carry[i] = R(0);
    }
}

//}
