
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
