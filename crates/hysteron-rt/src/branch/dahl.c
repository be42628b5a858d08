/* What a move by `by` changes y by. With x = 1 - s y/reach: x <- x exp(-ln(1 + (i - 1) q)/(i - 1)),
   q = x^(i-1) |by|/reach. */
static real branch_increment(real y, real from, real to)
{
    const real by = to - from;
    const bool down = by < R(0);
    const real x = R(1) - (down ? -y : y) / SHAPE[0];
    real q, lost = R(1), ignored;
    const real over = SHAPE[1] - R(1);
    if (x <= R(0)) {
        return down ? -(SHAPE[0] * x) : SHAPE[0] * x;
    }
    q = F(pow)(x, over) * ((down ? -by : by) / SHAPE[0]);
    if (over * q > R(-1)) {
        lost = relaxation(R(1), log_distance(over, q), &ignored);
    }
    lost = SHAPE[0] * (x * lost);
    return down ? -lost : lost;
}

/* What a move to u changes the state by; nothing is lost. */
static real branch_change(const $name_state *state, real u, real *own)
{
    own[0] = branch_increment(state->y[0], state->voltage, u);
    return R(0);
}
