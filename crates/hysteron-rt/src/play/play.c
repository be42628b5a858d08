//{ plays
/* A play of half-width r after a monotone move of its input to u. */
static real play(real r, real state, real u)
{
    const real low = u - r, high = u + r;
    const real kept = state > high ? high : state;
    return kept < low ? low : kept;
}

//}
//{ plays
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    real v = polynomial_at($TUNED_FIRSTu);
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        v = v + K(weight)[i] * u;
    }
    return v;
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    real sum = R(0);
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * play(THRESHOLD[i], state->play[i], u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    real moved[$NAME_PLAYS], sum = R(0);
    int32_t i;
    real out = polynomial_at($TUNED_FIRSTu);
    for (i = 0; i < $NAME_PLAYS; i++) {
        moved[i] = play(THRESHOLD[i], state->play[i], u);
        sum = sum + K(weight)[i] * moved[i];
    }
    out = out + sum;
    if (!is_in_range(out)) {
        return false;
    }
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = moved[i];
    }
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = u;
    }
}

//}
