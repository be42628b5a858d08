//+ shared functions
//+ law of a branch
//+ operators
/* The polynomial l[u]. */
static real polynomial_at($TUNED_AS_ARGUMENT_FIRSTreal u)
{
//{ polynomial
    real sum = R(0);
    int i;
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

/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
//{ plays
    real v = polynomial_at($TUNED_FIRSTu);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        v = v + K(weight)[i] * u;
    }
    return v;
//}
//{ sided
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * virgin_play(u, i);
    }
//{ envelopes
    if (F(tanh)(RIGHT[0] * (u - RIGHT[1])) - F(tanh)(LEFT[0] * (u - LEFT[1])) > R(2) * THRESHOLD[0] + R(4) * R(EPSILON)) {
        return F(HUGE_VAL); /* the narrowest has no place to stand */
    }
//}
//{ line
    sum = sum + line_at(u);
//}
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ activated
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + activated_output(u, i);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ plane
    return polynomial_at($TUNED_FIRSTu) + plane_at_rest(u);
//}
//{ branch
    const real state_there = branch_virgin(u);
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_STATES; i++) {
        sum = sum + K(weight)[i] * branch_output(state_there, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ bouc_wen|memoryless
    return polynomial_at($TUNED_FIRSTu);
//}
}

//{ looks
/* What a monotone move to u would put out$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
//{ bouc_wen
    real v = polynomial_at($TUNED_FIRSTu);
    int i;
    for (i = 0; i < $NAME_OPERATORS; i++) {
        v = v - (state->z[i] + increment(&K(operators)[i], state->z[i], u - state->voltage));
    }
    return v;
//}
//{ plays
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * play(THRESHOLD[i], state->play[i], u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, state->rested ? R(0) : du, u, (real *)0);
//}
//{ sided
//{ !rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, (real *)0);
//}
//}
//{ activated
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, share, (real *)0);
//}
//{ plane
    return polynomial_at($TUNED_FIRSTu) + plane_look(state, u).output;
//}
//{ branch
    real own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
    int i;
    for (i = 0; i < $NAME_STATES; i++) {
        const real y = state->y[i] + (own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ memoryless
    return polynomial_at($TUNED_FIRSTu);
//}
}

//}
/* Moves monotonically to u: *v is what the hysteresis puts out there. 0, and nothing has moved, where that is out of range. */
static int hysteresis_move($name_state *state, real u, real *v)
{
//{ bouc_wen
    real z[$NAME_OPERATORS], z_carry[$NAME_OPERATORS];
    const real du = u - state->voltage;
//}
//{ plays
    real moved[$NAME_PLAYS], sum = R(0);
//}
//{ plane
    const plane_move to = plane_look(state, u);
//}
//{ branch
    real y[$NAME_STATES], y_carry[$NAME_STATES], own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
//}
//{ rate
    const real du = state->rested ? R(0) : u - state->voltage;
//{ means
    const real middle = R(0.5) * state->voltage + R(0.5) * u;
//}
//{ !means
    const real middle = u;
//}
//}
//{ bouc_wen|plays|branch
    int i;
//}
    real out = polynomial_at($TUNED_FIRSTu);
//{ bouc_wen
    for (i = 0; i < $NAME_OPERATORS; i++) {
        z[i] = state->z[i];
        z_carry[i] = state->z_carry[i];
        accumulate(&z[i], &z_carry[i], increment(&K(operators)[i], state->z[i], du));
        out = out - z[i];
    }
//}
//{ plays
    for (i = 0; i < $NAME_PLAYS; i++) {
        moved[i] = play(THRESHOLD[i], state->play[i], u);
        sum = sum + K(weight)[i] * moved[i];
    }
    out = out + sum;
//}
//{ rate
    out = out + plays_at(state, middle, du, u, (real *)0);
//}
//{ sided
//{ !rate
    out = out + plays_at(state, u, (real *)0);
//}
//}
//{ activated
    out = out + plays_at(state, u, R(1), (real *)0);
//}
//{ plane
    out = out + to.output;
//}
//{ branch
    for (i = 0; i < $NAME_STATES; i++) {
        y[i] = state->y[i];
        y_carry[i] = state->y_carry[i];
        accumulate(&y[i], &y_carry[i], own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y[i], u);
    }
    out = out + sum;
//}
    if (!is_in_range(out)) {
        return 0;
    }
//{ bouc_wen
    for (i = 0; i < $NAME_OPERATORS; i++) {
        state->z[i] = z[i];
        state->z_carry[i] = z_carry[i];
    }
//}
//{ plays
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = moved[i];
    }
//}
//{ rate
    (void)plays_at(state, middle, du, u, state->play);
    state->rested = 0;
//}
//{ sided
//{ !rate
    (void)plays_at(state, u, state->play);
//}
//}
//{ activated
    (void)plays_at(state, u, R(1), state->play);
    state->rested = 0;
//}
//{ plane
    plane_make(state, to, u);
//}
//{ branch
    for (i = 0; i < $NAME_STATES; i++) {
        state->y[i] = y[i];
        state->y_carry[i] = y_carry[i];
    }
//}
    state->voltage = u;
    *v = out;
    return 1;
}

