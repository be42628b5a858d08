//{ sided
/* `state`, pushed as far as its sides push it; at low where they cross. */
static real between(real low, real high, real state)
{
    const real held = state > high ? high : state;
    return held < low ? low : held;
}

//}
//{ ramps
static real ramp(real x)
{
    return between(R(-1), R(1), STEEPNESS * x);
}

//}
//{ line
/* The broken line of the mean of the plays. */
static real line_at(real h)
{
    real sum = h < CORNER[0] ? SLOPE[0] * (h - CORNER[0]) : R(0);
    int32_t i;
    for (i = 1; i < $N_CORNERS; i++) {
        const real inside = h > CORNER[i] ? CORNER[i] : h;
        if (inside > CORNER[i - 1]) {
            sum = sum + SLOPE[i] * (inside - CORNER[i - 1]);
        }
    }
    return h > CORNER[$N_CORNERS - 1] ? sum + SLOPE[$N_CORNERS] * (h - CORNER[$N_CORNERS - 1]) : sum;
}

//}
//{ sided
/* What the plays put out after a monotone move$THROUGH_IN_WORDS to u; they go there in `moved`, where that is
   given. */
static real plays_at(const $name_state *state, $THROUGH_PARAMETERreal u, real *moved)
{
    real sum = R(0);
//{ line
    real behind = R(0);
//}
//{ rate
    /* First the sides in the middle, then those at the end: upwards the low one at the end decides, downwards
       the high one. */
    const real wider = WIDENING * F(fabs)(du), above = middle > u ? u : middle;
    const real below = middle > u ? middle : u;
//}
//{ envelopes
    const real right = F(tanh)(RIGHT[0] * (u - RIGHT[1])), left = F(tanh)(LEFT[0] * (u - LEFT[1]));
//}
//{ ramps
    real first = ramp(u - THRESHOLD[0]);
    int32_t row = 0, column = 0;
//}
    int32_t i;
//{ envelopes
    if (right - left > R(2) * THRESHOLD[0] + R(4) * R(EPSILON)) {
        return F(HUGE_VAL); /* the narrowest has no place to stand */
    }
//}
    for (i = 0; i < $NAME_PLAYS; i++) {
//{ even
        const real low = u - THRESHOLD[i], high = u + THRESHOLD[i];
//}
//{ rate
        const real r = THRESHOLD[i] + wider, high = above + r;
        const real low = middle > u && below - r > high ? high : below - r;
//}
//{ below
        const real low = u - THRESHOLD[i], high = u;
//}
//{ envelopes
        const real low = right - THRESHOLD[i], high = left + THRESHOLD[i];
//}
//{ ramps
        const real low = first, high = ramp(u - THRESHOLD[column]);
//}
        const real stands = between(low, high, state->play[i]);
        sum = sum + K(weight)[i] * stands;
//{ line
        behind = behind + SHARE[i] * (stands - u);
//}
        if (moved) {
            moved[i] = stands;
        }
//{ ramps
        if (++column > row) {
            row++;
            column = 0;
            first = row < $N_THRESHOLDS ? ramp(u - THRESHOLD[row]) : R(0);
        }
//}
    }
//{ line
    return sum + line_at(u + behind);
//}
//{ !line
    return sum;
//}
}

/* Where play number i is virgin at u. */
static real virgin_play(real u, int32_t i)
{
//{ even|rate|below
    (void)i;
    return u;
//}
//{ envelopes
    (void)i;
    return R(0.5) * (F(tanh)(RIGHT[0] * (u - RIGHT[1])) + F(tanh)(LEFT[0] * (u - LEFT[1])));
//}
//{ ramps
    int32_t row = 0;
    while (i > row) {
        row++;
        i -= row;
    }
    return ramp(u - (R(0.5) * THRESHOLD[row] + R(0.5) * THRESHOLD[i]));
//}
}

//}
//{ sided
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    real sum = R(0);
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * virgin_play(u, i);
    }
//{ envelopes
    if (F(tanh)(RIGHT[0] * (u - RIGHT[1])) - F(tanh)(LEFT[0] * (u - LEFT[1]))
        > R(2) * THRESHOLD[0] + R(4) * R(EPSILON)) {
        return F(HUGE_VAL); /* the narrowest has no place to stand */
    }
//}
//{ line
    sum = sum + line_at(u);
//}
    return polynomial_at($TUNED_FIRSTu) + sum;
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
//{ rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, state->rested ? R(0) : du, u, (real *)0);
//}
//{ !rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, (real *)0);
//}
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
//{ rate
    const real du = state->rested ? R(0) : u - state->voltage;
//{ means
    const real middle = R(0.5) * state->voltage + R(0.5) * u;
//}
//{ !means
    const real middle = u;
//}
    const real out = polynomial_at($TUNED_FIRSTu) + plays_at(state, middle, du, u, (real *)0);
//}
//{ !rate
    const real out = polynomial_at($TUNED_FIRSTu) + plays_at(state, u, (real *)0);
//}
    if (!is_in_range(out)) {
        return false;
    }
//{ rate
    (void)plays_at(state, middle, du, u, state->play);
    state->rested = false;
//}
//{ !rate
    (void)plays_at(state, u, state->play);
//}
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = virgin_play(u, i);
    }
//{ rate
    state->rested = true;
//}
}

//}
