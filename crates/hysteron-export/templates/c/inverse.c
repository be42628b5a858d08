static real within(real x, real low, real high)
{
    if (x < low) {
        return low;
    }
    return x > high ? high : x;
}

typedef struct {
    real voltage, output;
    bool missed; /* the target lies beyond */
} reached;

static reached reached_at(const $name_state *state, real voltage)
{
    reached there;
    there.voltage = voltage;
    there.output = hysteresis_look(state, voltage$AT_END);
    there.missed = false;
    return there;
}

/* The voltage from low to high, about the present one, to which one monotone move gives `target`: secants
   kept within a bracket (Illinois: M. Dowell, P. Jarratt 1971, doi:10.1007/BF01934364), every third step a
   halving, at most $MOST_LOOKS looks. */
static reached reach(const $name_state *state, real target, real low, real high)
{
//{ moves_at_rest
    /* Plays that a fast move has left behind, or that creep, come on where the voltage stays. */
    const real output = hysteresis_look(state, state->voltage$AT_REST);
//}
//{ !moves_at_rest
    const real output = state->output;
//}
    const bool upwards = target > output;
    const real end = upwards ? high : low;
    reached near, far;
    real guess, close, near_excess, far_excess;
    bool inside;
    int32_t count, kept = 0; /* the end kept last: 1 near, 2 far */
    near.voltage = state->voltage;
    near.output = output;
    near.missed = false;
    if (target == output || end == near.voltage) {
        near.missed = target != output;
        return near;
    }
    /* A step that overshoots a little, so that the search begins with a narrow bracket. */
    guess = near.voltage + R(1.25) * (target - output) / state->slope;
    inside = upwards ? near.voltage < guess && guess < end : end < guess && guess < near.voltage;
    far = reached_at(state, inside ? guess : end);
/* Where there is no place to stand it is beyond, too. */
#define BEYOND(v) (!(is_finite(v) && (upwards ? (v) < target : (v) > target)))
    if (inside && !BEYOND(far.output)) {
        near = far;
        far = reached_at(state, end);
    }
    if (!BEYOND(far.output)) {
        far.missed = true;
        return far;
    }
    close = R(2) * R(EPSILON) * (F(fabs)(target) + F(fabs)(output));
    near_excess = near.output - target;
    far_excess = far.output - target;
    for (count = 2; count < $MOST_LOOKS; count++) {
        const real width = far.voltage - near.voltage;
        const real share = near_excess / (near_excess - far_excess);
        const bool halve = count % 3 == 1 || !is_finite(share);
        real between = near.voltage + width * (halve ? R(0.5) : share);
        reached next;
        if (F(fabs)(near_excess) <= close || F(fabs)(far_excess) <= close) {
            break;
        }
        if (between == near.voltage || between == far.voltage) {
            between = near.voltage + R(0.5) * width;
        }
        if (between == near.voltage || between == far.voltage) {
            break;
        }
        next = reached_at(state, between);
        /* The value of an end that stays for the second time counts half. */
        if (BEYOND(next.output)) {
            far = next;
            far_excess = next.output - target;
            if (kept == 1) {
                near_excess = R(0.5) * near_excess;
            }
            kept = 1;
        } else {
            near = next;
            near_excess = next.output - target;
            if (kept == 2) {
                far_excess = R(0.5) * far_excess;
            }
            kept = 2;
        }
    }
#undef BEYOND
    if (!is_finite(far.output)) {
        near.missed = true;
        return near;
    }
    return F(fabs)(near.output - target) < F(fabs)(far.output - target) ? near : far;
}

/* What the hysteresis is to put out: a linear regulator with preview, counted from the last output v_1 so
   that a reference at rest is met exactly.
   v = v_1 + sum recent (v_l - v_1) + sum k (x - v_1) + sum f (r - y_1). */
static real wanted(const $name_state *state, real disturbance)
{
    const real newest = state->recent[0];
    const real gain = state->trims.gain, per_gain = R(1) / gain;
    const real settles = state->trims.offset + gain * (REST_GAIN * state->rest) + gain * (GAIN * newest)
        + disturbance;
    real sum = R(0);
    uint32_t at = state->ring_at;
    int32_t i;
//{ law_recent
    for (i = 0; i < $N_LAW_RECENT; i++) {
        sum = sum + LAW_RECENT[i] * (state->recent[i + 1] - newest);
    }
//}
//{ real_poles
    for (i = 0; i < $NAME_REAL_POLES; i++) {
        sum = sum + LAW_REAL[i] * (state->real_x[i] - newest);
    }
//}
//{ pairs
    for (i = 0; i < $NAME_PAIRS; i++) {
        sum = sum + LAW_PAIR[i][0] * (state->pair_x[i][0] - newest) + LAW_PAIR[i][1] * state->pair_x[i][1];
    }
//}
    for (i = 0; i < $NAME_REFERENCES; i++) {
        at = at > 0u ? at - 1u : (uint32_t)$NAME_REFERENCES - 1u;
        sum = sum + LAW_REFERENCE[i] * ((state->ring[at] - settles) * per_gain);
    }
    return state->rest + (newest + sum);
}

/* The reference has been here for ever. */
static void stand_at($name_state *state, real displacement)
{
    int32_t i;
    for (i = 0; i < $NAME_REFERENCES; i++) {
        state->ring[i] = displacement;
    }
    state->ring_at = 0u;
    state->reference = displacement;
}

void $name_init($name_state *state)
{
    real ignored;
//{ tunable
    state->parameters = DEFAULTS;
//}
    state->trims.gain = R(1);
    state->trims.offset = OFFSET;
    state->displacement = OFFSET;
    state->voltage = R(0);
    (void)$name_rest_at(state, R(0), &ignored);
}

$name_status $name_rest_at($name_state *state, real voltage, real *displacement)
{
    return $name_rest_after(state, voltage, voltage, displacement);
}

$name_status $name_rest_after($name_state *state, real virgin, real voltage, real *displacement)
{
    const real away = R(0.001) * ($NAME_VOLTAGE_HIGH - $NAME_VOLTAGE_LOW);
    const real stood = within(state->voltage, $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH);
    $name_status status = $NAME_OK;
    real rise, v;
    *displacement = state->displacement;
    if (!is_finite(voltage) || !is_finite(virgin)) {
        return $NAME_NOT_FINITE;
    }
    voltage = within(voltage, $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH);
    if (!settle_after(state, virgin, voltage, &v)) {
        /* Virgin where it stood. */
        voltage = stood;
        v = hysteresis_at_rest($TUNED_FIRSTvoltage);
        settle(state, voltage, v);
        state->displacement = state->trims.offset + state->trims.gain * (REST_GAIN * v);
        status = $NAME_OVERFLOW;
    }
    state->output = v;
    stand_at(state, state->displacement);
    /* The slope from rest, for the first guess. */
    rise = (hysteresis_look(state, voltage + away$AWAY) - v) / away;
    state->slope = rise > R(0) && is_finite(rise) ? rise : R(1);
    *displacement = state->displacement;
    return status;
}

$name_status $name_measured_at_rest($name_state *state, real displacement)
{
    const real offset = displacement - state->trims.gain * (REST_GAIN * state->rest);
    if (!is_finite(offset)) {
        return $NAME_NOT_FINITE;
    }
    state->trims.offset = offset;
    state->displacement = displacement;
    stand_at(state, displacement);
    return $NAME_OK;
}

$name_status $name_know($name_state *state, real reference)
{
    const bool sound = is_finite(reference);
    if (sound) {
        state->reference = reference;
    }
    state->ring[state->ring_at] = state->reference;
    state->ring_at = state->ring_at + 1u < (uint32_t)$NAME_REFERENCES ? state->ring_at + 1u : 0u;
    return sound ? $NAME_OK : $NAME_NOT_FINITE;
}

$name_status $name_step($name_state *state, real reference, real *voltage)
{
    return $name_step_against(state, reference, R(0), voltage);
}

$name_status $name_step_against($name_state *state, real reference, real disturbance, real *voltage)
{
    bool sound = $name_know(state, reference) == $NAME_OK;
    real target = wanted(state, is_finite(disturbance) ? disturbance : R(0)), rise, v;
    const real from = state->voltage;
    reached there;
    if (!is_finite(target)) {
        target = state->output;
        sound = false;
    }
    there = reach(state, target, within(from - $NAME_VOLTAGE_STEP, $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH),
                  within(from + $NAME_VOLTAGE_STEP, $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH));
    *voltage = from;
    if (!hysteresis_move(state, there.voltage, &v)) {
        state->displacement = state->trims.offset + state->trims.gain * dynamics_step(state, state->output);
        return $NAME_OVERFLOW;
    }
    rise = (v - state->output) / (there.voltage - from);
    if (rise > R(0) && is_finite(rise)) {
        state->slope = rise;
    }
    state->output = v;
    state->displacement = state->trims.offset + state->trims.gain * dynamics_step(state, v);
    *voltage = there.voltage;
    if (!sound) {
        return $NAME_NOT_FINITE;
    }
    if (!there.missed) {
        return $NAME_OK;
    }
    return there.voltage <= $NAME_VOLTAGE_LOW || there.voltage >= $NAME_VOLTAGE_HIGH ? $NAME_AT_RANGE
                                                                                     : $NAME_AT_SLEW;
}

$name_status $name_trim($name_state *state, const $name_trims *trims)
{
    if (!is_finite(trims->gain) || !is_finite(trims->offset) || trims->gain == R(0)) {
        return $NAME_NOT_FINITE;
    }
    state->trims = *trims;
    return $NAME_OK;
}
