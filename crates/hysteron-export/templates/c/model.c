static $name_status status_of(real u)
{
//{ range
    const real slack = R(0.01) * ($NAME_VOLTAGE_HIGH - $NAME_VOLTAGE_LOW);
    if (u < $NAME_VOLTAGE_LOW - slack || u > $NAME_VOLTAGE_HIGH + slack) {
        return $NAME_EXTRAPOLATED;
    }
//}
//{ !range
    (void)u;
//}
    return $NAME_OK;
}

void $name_init($name_state *state)
{
//{ tunable
    state->parameters = DEFAULTS;
//}
    state->trims.gain = R(1);
    state->trims.offset = OFFSET;
    settle(state, R(0), hysteresis_at_rest($TUNED_FIRSTR(0)));
    state->displacement = state->trims.offset + state->trims.gain * (REST_GAIN * state->rest);
}

$name_status $name_rest_at($name_state *state, real voltage, real *displacement)
{
    return $name_rest_after(state, voltage, voltage, displacement);
}

$name_status $name_rest_after($name_state *state, real virgin, real voltage, real *displacement)
{
    real v;
    *displacement = state->displacement;
    if (!is_finite(voltage) || !is_finite(virgin)) {
        return $NAME_NOT_FINITE;
    }
    if (!settle_after(state, virgin, voltage, &v)) {
        return $NAME_OVERFLOW;
    }
    *displacement = state->displacement;
    return status_of(voltage);
}

$name_status $name_start_at($name_state *state, real voltage, real displacement)
{
    $name_status status;
    real there;
    if (!is_finite(displacement)) {
        return $NAME_NOT_FINITE;
    }
    status = $name_rest_at(state, voltage, &there);
    if (status >= $NAME_OK) {
        there = displacement - state->trims.gain * (REST_GAIN * state->rest);
        if (!is_finite(there)) {
            return $NAME_NOT_FINITE;
        }
        state->trims.offset = there;
        state->displacement = displacement;
    }
    return status;
}

$name_status $name_step($name_state *state, real voltage, real *displacement)
{
    real v;
//{ means
    real middle;
//}
    *displacement = state->displacement;
    if (!is_finite(voltage)) {
        return $NAME_NOT_FINITE;
    }
//{ means
    /* Half-way: from the start of the move, as its end is. */
    middle = hysteresis_look(state, R(0.5) * state->voltage + R(0.5) * voltage$AT_HALF);
    if (!is_in_range(middle)) {
        return $NAME_OVERFLOW;
    }
//}
    if (!hysteresis_move(state, voltage, &v)) {
        return $NAME_OVERFLOW;
    }
//{ means
    /* A polygon through what enters the dynamics has the means of v: a straight line leaves out two thirds of
       what is between (Simpson). */
    {
        const real left_out = R(2/3) * (middle - R(0.5) * (state->last_v + v));
        state->last_v = v;
        v = v + left_out;
    }
//}
    state->displacement = state->trims.offset + state->trims.gain * dynamics_step(state, v);
    *displacement = state->displacement;
    return status_of(voltage);
}

$name_status $name_trim($name_state *state, const $name_trims *trims)
{
    if (!is_finite(trims->gain) || !is_finite(trims->offset) || trims->gain == R(0)) {
        return $NAME_NOT_FINITE;
    }
    state->trims = *trims;
    return $NAME_OK;
}
