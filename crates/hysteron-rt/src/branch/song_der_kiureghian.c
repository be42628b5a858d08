/* A move on one side of 0 is one of a state law with n = 1. */
static real one_sided_increment(bool negative, real y, real by)
{
    const bool down = by < R(0);
    const real b2 = negative ? -SHAPE[1] : SHAPE[1], b3 = negative ? -SHAPE[2] : SHAPE[2];
    const real b6 = negative ? -SHAPE[5] : SHAPE[5];
    const real turned = b3 + SHAPE[4], straight = b2 + SHAPE[3];
    state_law p;
    p.alpha = R(1);
    p.beta = SHAPE[0] + (down ? -turned : turned);
    p.gamma = (down ? -straight : straight) + b6;
    p.n = R(1);
    return increment(&p, y, by);
}

/* What a move changes y by. */
static real branch_increment(real y, real from, real to)
{
    if (from * to < R(0)) {
        const real first = one_sided_increment(from < R(0), y, -from);
        return first + one_sided_increment(to < R(0), y + first, to);
    }
    return one_sided_increment(to == R(0) ? from < R(0) : to < R(0), y, to - from);
}

/* What a move to u changes the state by; nothing is lost. */
static real branch_change(const $name_state *state, real u, real *own)
{
    own[0] = branch_increment(state->y[0], state->voltage, u);
    return R(0);
}
