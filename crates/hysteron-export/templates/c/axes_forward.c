
//{ range
static bool extrapolates(real u)
{
    const real slack = R(0.01) * ($NAME_VOLTAGE_HIGH - $NAME_VOLTAGE_LOW);
    return u < $NAME_VOLTAGE_LOW - slack || u > $NAME_VOLTAGE_HIGH + slack;
}

//}
void $name_init($name_state *state)
{
    static const real none[INPUTS];
    settle(state, none);
}

$name_status $name_rest_at($name_state *state, const $name_real voltages[$NAME_INPUTS])
{
    int32_t i;
    for (i = 0; i < INPUTS; i++) {
        if (!is_finite(voltages[i])) {
            return $NAME_NOT_FINITE;
        }
    }
    settle(state, voltages);
//{ range
    for (i = 0; i < INPUTS; i++) {
        if (extrapolates(voltages[i])) {
            return $NAME_EXTRAPOLATED;
        }
    }
//}
    return $NAME_OK;
}

$name_status $name_step($name_state *state, const $name_real voltages[$NAME_INPUTS],
                        $name_real outputs[$NAME_OUTPUTS])
{
    $name_status status = $NAME_OK;
    real u[INPUTS];
    int32_t i, m;
    for (i = 0; i < INPUTS; i++) {
        u[i] = voltages[i];
        if (!is_finite(u[i])) {
            u[i] = state->held[i];
            status = $NAME_NOT_FINITE;
        }
//{ range
        if (extrapolates(u[i]) && status == $NAME_OK) {
            status = $NAME_EXTRAPOLATED;
        }
//}
    }
    next_sample(state);
    if (!apply(state, u)) {
        status = $NAME_OVERFLOW;
    }
    for (m = 0; m < OUTPUTS; m++) {
        outputs[m] = state->output[m];
    }
    return status;
}
