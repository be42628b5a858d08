/* What a move to u changes the states by: y[i] by own[i] - lost y[i], lost being handed back. */
static real branch_change(const $name_state *state, real u, real *own)
{
    const real by = u - state->voltage;
    const real x = SHAPE[0] * F(fabs)(by);
    real power = by, lost;
    int32_t j, k;
    moments(x, $NAME_STATES, own);
    lost = x * own[0];
    for (k = 0; k < $NAME_STATES; k++) {
        own[k] = power * own[k];
        power = power * by;
    }
    for (j = 1; j < $NAME_STATES; j++) {
        for (k = $NAME_STATES - 1; k >= j; k--) {
            own[k] = own[k] + state->voltage * own[k - 1];
        }
    }
    return lost;
}
