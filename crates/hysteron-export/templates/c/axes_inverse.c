
#define PREVIEW $NAME_PREVIEW
/* Share by which the change of the strains moves to the newest one. */
#define SMOOTHING $SMOOTHING

/* The voltage nearest to `wanted` within range and slew of an actuator. */
static real limited(int32_t i, real wanted, real last, $name_status *status)
{
    const real target = is_finite(wanted) ? wanted : last;
    const real ranged = target < LOW[i] ? LOW[i] : target > HIGH[i] ? HIGH[i] : target;
    const real least = last - STEP[i], most = last + STEP[i];
    const real slewed = ranged < least ? least : ranged > most ? most : ranged;
    if (slewed != ranged && *status >= $NAME_OK) {
        *status = $NAME_AT_SLEW;
    } else if (ranged != target && *status == $NAME_OK) {
        *status = $NAME_AT_RANGE;
    }
    return slewed;
}

static void rest($name_state *state, const real *voltages)
{
    int32_t i, k, m;
    real u[INPUTS];
    for (i = 0; i < INPUTS; i++) {
        u[i] = voltages[i] < LOW[i] ? LOW[i] : voltages[i] > HIGH[i] ? HIGH[i] : voltages[i];
    }
    settle(state, u);
    for (i = 0; i < INPUTS; i++) {
        state->before[i] = u[i];
        state->predicted[i] = state->strain[i];
    }
    for (k = 0; k <= PREVIEW; k++) {
        for (m = 0; m < OUTPUTS; m++) {
            state->window[k][m] = state->output[m];
        }
    }
}

void $name_init($name_state *state)
{
    static const real none[INPUTS];
    rest(state, none);
}

$name_status $name_rest_at($name_state *state, const $name_real voltages[$NAME_INPUTS],
                           $name_real outputs[$NAME_OUTPUTS])
{
    int32_t i, m;
    for (i = 0; i < INPUTS; i++) {
        if (!is_finite(voltages[i])) {
            return $NAME_NOT_FINITE;
        }
    }
    rest(state, voltages);
    for (m = 0; m < OUTPUTS; m++) {
        outputs[m] = state->output[m];
    }
    return $NAME_OK;
}

$name_status $name_know($name_state *state, const $name_real references[$NAME_OUTPUTS])
{
    const int32_t last = (state->present + PREVIEW) % (PREVIEW + 1);
    $name_status status = $NAME_OK;
    int32_t m;
    for (m = 0; m < OUTPUTS; m++) {
        real r = references[m];
        if (!is_finite(r)) {
            r = state->window[last][m];
            status = $NAME_NOT_FINITE;
        }
        state->window[state->present][m] = r;
    }
    state->present = (state->present + 1) % (PREVIEW + 1);
    return status;
}

$name_status $name_step($name_state *state, const $name_real references[$NAME_OUTPUTS],
                        $name_real voltages[$NAME_INPUTS])
{
    $name_status status = $name_know(state, references);
    real u[INPUTS];
    int32_t i, j;
    for (i = 0; i < INPUTS; i++) {
        state->last_strain[i] = state->strain[i];
    }
    next_sample(state);
    for (i = 0; i < INPUTS; i++) {
        real wanted = dot(LAW_STATES[i], state->x, STATES) + dot(LAW_LAST[i], state->held, INPUTS)
            + dot(LAW_BEFORE[i], state->before, INPUTS) + dot(LAW_STRAINS[i], state->predicted, INPUTS)
            + dot(LAW_RATES[i], state->rate, INPUTS);
        for (j = 0; j <= PREVIEW; j++) {
            wanted += dot(LAW_REFERENCES[j][i], state->window[(state->present + j) % (PREVIEW + 1)], OUTPUTS);
        }
        u[i] = limited(i, wanted, state->held[i], &status);
    }
    for (i = 0; i < INPUTS; i++) {
        state->before[i] = state->held[i];
        voltages[i] = u[i];
    }
    if (!apply(state, u)) {
        status = $NAME_OVERFLOW;
        for (i = 0; i < INPUTS; i++) {
            state->last_strain[i] = state->strain[i];
            state->rate[i] = R(0);
        }
    }
    for (i = 0; i < INPUTS; i++) {
        state->rate[i] += SMOOTHING * (state->strain[i] - state->last_strain[i] - state->rate[i]);
        state->predicted[i] = state->strain[i] + state->rate[i];
    }
    return status;
}
