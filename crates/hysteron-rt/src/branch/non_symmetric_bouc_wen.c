/* What a way t at the rate kappa changes y by. */
static real along(real kappa, real s, real u, real y, real t)
{
    real m[2];
    moments(kappa * t, 2, m);
    return t * m[0] * (s + SHAPE[2] * u - kappa * y) + SHAPE[2] * s * t * t * m[1];
}

/* y outwards from 0 after a way t: rate, s, start, y, and whether it is negative. */
static real outwards(const rising_function *f, real t, real *slope)
{
    const real state = f->number[3] + along(f->number[0], f->number[1], f->number[2], f->number[3], t);
    *slope = f->number[1] + SHAPE[2] * (f->number[2] + f->number[1] * t) - f->number[0] * state;
    if (f->number[4] < R(0)) {
        return state;
    }
    *slope = -*slope;
    return -state;
}

/* A move on which 1 + delta s u keeps its sign. */
static real one_way_increment(real s, real y, real from, real to)
{
    const real way = (to - from) * s;
    const real drive = s + SHAPE[2] * (R(0.5) * from + R(0.5) * to);
    const bool negative = y == R(0) ? drive < R(0) : y < R(0);
    const real turned = s * SHAPE[1];
    const real rate = SHAPE[0] + (negative ? -turned : turned);
    const real end = along(rate, s, from, y, way);
    rising_function f;
    real t;
    if (negative ? y + end <= R(0) : y + end >= R(0)) {
        return end;
    }
    f.at = outwards;
    f.number[0] = rate;
    f.number[1] = s;
    f.number[2] = from;
    f.number[3] = y;
    f.number[4] = negative ? R(-1) : R(1);
    t = rising_root(&f, R(0), way, R(0.5) * way);
    return -y + along(SHAPE[0] + (negative ? turned : -turned), s, from + s * t, R(0), way - t);
}

/* What a move changes y by. */
static real branch_increment(real y, real from, real to)
{
    const real s = to < from ? R(-1) : R(1);
    if (SHAPE[2] != R(0)) {
        const real turn = -s / SHAPE[2];
        if ((turn - from) * s > R(0) && (to - turn) * s > R(0)) {
            const real first = one_way_increment(s, y, from, turn);
            return first + one_way_increment(s, y + first, turn, to);
        }
    }
    return one_way_increment(s, y, from, to);
}

/* What a move to u changes the state by; nothing is lost. */
static real branch_change(const $name_state *state, real u, real *own)
{
    own[0] = branch_increment(state->y[0], state->voltage, u);
    return R(0);
}
