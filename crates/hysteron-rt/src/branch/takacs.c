/* Half of 1 + tanh z. */
static real risen(real z)
{
    if (z < R(0)) {
        const real tail = F(exp)(R(2) * z);
        return tail / (R(1) + tail);
    }
    return R(1) / (R(1) + F(exp)(R(-2) * z));
}

/* What a move to u changes the state by; nothing is lost. */
static real branch_change(const $name_state *state, real u, real *own)
{
    const bool down = u < state->voltage;
    const real y = down ? -state->y[0] : state->y[0];
    const real way = down ? state->voltage - u : u - state->voltage;
    const real beyond = down ? SHAPE[0] - u : u - SHAPE[0];
    real ignored;
    const real passed = relaxation(R(1), R(2) * way / SHAPE[1], &ignored);
    const real change = (R(1) - y) * (passed * risen((beyond - SHAPE[2]) / SHAPE[1]));
    own[0] = down ? -change : change;
    return R(0);
}

/* The state, virgin at u. */
static real branch_virgin(real u)
{
    const real x = (u - SHAPE[0]) / SHAPE[1];
    const real size = F(fabs)(x);
    const real q = F(exp)(R(-2) * size), tails = q * q;
    const real y = (R(1) - tails) / (R(1) + tails + R(2) * (q * F(exp)(R(-2) * SHAPE[2] / SHAPE[1])));
    return x < R(0) ? -y : y;
}
