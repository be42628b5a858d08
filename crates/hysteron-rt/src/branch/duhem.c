/* What a move to u changes the states by: y[i] by own[i] - lost y[i], lost being handed back. */
static real branch_change(const $name_state *state, real u, real *own)
{
    const real by = u - state->voltage;
    const real x = SHAPE[0] * F(fabs)(by);
    real a[$NAME_STATES], power = by, ignored;
    int j, k;
    moments(x, $NAME_STATES, a);
    for (k = 0; k < $NAME_STATES; k++) {
        a[k] = power * a[k];
        power = power * by;
    }
    for (j = 0; j < $NAME_STATES; j++) {
        own[j] = a[0];
        for (k = 0; k < $NAME_STATES - 1 - j; k++) {
            a[k] = state->voltage * a[k] + a[k + 1];
        }
    }
    return relaxation(R(1), x, &ignored);
}
