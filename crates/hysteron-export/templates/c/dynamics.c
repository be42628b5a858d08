/* The dynamics: their output after the input w. The same number of operations every time. */
static real dynamics_step($name_state *state, real w)
{
    /* States decay towards a level far below any signal instead of through the subnormal numbers. */
    real newest = w - state->rest + R(FLOOR);
    real sum = REST_GAIN * state->rest;
    int32_t i;
//{ delay
    {
        const real oldest = state->delayed[state->at];
        state->delayed[state->at] = newest;
        newest = oldest;
        state->at = state->at + 1u < (uint32_t)$NAME_DELAY ? state->at + 1u : 0u;
    }
//}
    for (i = $NAME_TAPS; i > 0; i--) {
        state->recent[i] = state->recent[i - 1];
    }
    state->recent[0] = newest;
    for (i = 0; i < $NAME_TAPS; i++) {
        sum = sum + TAP[i] * state->recent[i];
    }
//{ real_poles
    {
        const real drive = state->recent[$NAME_TAPS];
        real lane[4] = {R(0), R(0), R(0), R(0)};
        for (i = 0; i < $NAME_REAL_POLES; i++) {
            accumulate(&state->real_x[i], &state->real_carry[i], REAL_GAIN[i] * (drive - state->real_x[i]));
            lane[i & 3] = lane[i & 3] + REAL_WEIGHT[i] * state->real_x[i];
        }
        sum = sum + ((lane[0] + lane[2]) + (lane[1] + lane[3]));
    }
//}
//{ pairs
    for (i = 0; i < $NAME_PAIRS; i++) {
        real *x = state->pair_x[i], *carry = state->pair_carry[i];
        const real *g = PAIR_GAIN[i], *c = PAIR_WEIGHT[i];
        const real left_re = state->recent[$NAME_TAPS] - x[0], left_im = R(FLOOR) - x[1];
        accumulate(&x[0], &carry[0], g[0] * left_re - g[1] * left_im);
        accumulate(&x[1], &carry[1], g[0] * left_im + g[1] * left_re);
        sum = sum + (c[0] * x[0] - c[1] * x[1]);
    }
//}
    return sum;
}

/* At rest, and virgin, at u, where the hysteresis puts out v. */
static void settle($name_state *state, real u, real v)
{
    int32_t i;
    state->voltage = u;
    hysteresis_rest(state, u);
//{ means
    state->last_v = v;
//}
    state->rest = v;
    for (i = 0; i <= $NAME_TAPS; i++) {
        state->recent[i] = R(0);
    }
//{ real_poles
    for (i = 0; i < $NAME_REAL_POLES; i++) {
        state->real_x[i] = R(0);
        state->real_carry[i] = R(0);
    }
//}
//{ pairs
    for (i = 0; i < $NAME_PAIRS; i++) {
        state->pair_x[i][0] = R(0);
        state->pair_x[i][1] = R(0);
        state->pair_carry[i][0] = R(0);
        state->pair_carry[i][1] = R(0);
    }
//}
//{ delay
    for (i = 0; i < $NAME_DELAY; i++) {
        state->delayed[i] = R(0);
    }
    state->at = 0u;
//}
}

/* Virgin at `virgin`, moved to u without turning, and at rest there: *v is what the hysteresis puts out. 0
   where that is out of range: the state is as it was, or at rest at `virgin` where it was the move that
   failed. */
static bool settle_after($name_state *state, real virgin, real u, real *v)
{
    *v = hysteresis_at_rest($TUNED_FIRSTvirgin);
    if (!is_in_range(*v)) {
        return false;
    }
    settle(state, virgin, *v);
    state->displacement = state->trims.offset + state->trims.gain * (REST_GAIN * *v);
    if (u != virgin) {
        if (!hysteresis_move(state, u, v)) {
            return false;
        }
        state->rest = *v;
        state->displacement = state->trims.offset + state->trims.gain * (REST_GAIN * *v);
//{ means
        state->last_v = *v;
//}
    }
    return true;
}

