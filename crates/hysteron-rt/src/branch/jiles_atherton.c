/* L(x) = coth x - 1/x. */
static real langevin(real x)
{
    if (F(fabs)(x) < R(2)) {
        const real square = x * x;
        real tail = R(27);
        int32_t k;
        for (k = 12; k >= 1; k--) {
            tail = square / tail + (real)(2 * k + 1);
        }
        return x / tail;
    }
    return R(1) / F(tanh)(x) - R(1) / x;
}

static real anhysteretic(real field)
{
    return langevin(field / SHAPE[0]);
}

/* And its slope. */
static real anhysteretic_slope(real field)
{
    const real x = field / SHAPE[0];
    real value, ratio;
    if (F(fabs)(x) > R(50)) {
        return R(1) / (x * x) / SHAPE[0];
    }
    value = langevin(x);
    ratio = F(fabs)(x) < R(1e-8) ? R(1/3) : value / x;
    return (R(1) - value * value - R(2) * ratio) / SHAPE[0];
}

/* p + c (m_an - p). */
static real magnetisation(real c, real field, real p)
{
    return p + c * (anhysteretic(field) - p);
}

/* Voltage of a field less the one wanted: that, p, c. */
static real voltage_excess(const rising_function *f, real h, real *slope)
{
    *slope = R(1) - SHAPE[3] * f->number[2] * anhysteretic_slope(h);
    return h - f->number[0] - SHAPE[3] * magnetisation(f->number[2], h, f->number[1]);
}

/* The field at the voltage u while p stays, from a guess of it. */
static real frozen_field(real c, real u, real p, real guess)
{
    const real most = F(fabs)(p) > R(1) ? F(fabs)(p) : R(1);
    const real reach = SHAPE[3] * most * (R(1) + R(16) * R(EPSILON));
    rising_function f;
    if (reach <= R(0)) {
        return u;
    }
    f.at = voltage_excess;
    f.number[0] = u;
    f.number[1] = p;
    f.number[2] = c;
    return rising_root(&f, u - reach, u + reach, guess);
}

/* m_an less the p wanted. */
static real anhysteretic_excess(const rising_function *f, real h, real *slope)
{
    *slope = anhysteretic_slope(h);
    return anhysteretic(h) - f->number[0];
}

/* What p changes by while the field moves by `way`, by four or eight Gauss points. */
static real relaxed(real field, real p, real sign, real way)
{
    static const real point[12][2] = {
        {R(0.06943184420297371), R(0.17392742256872693)}, {R(0.33000947820757187), R(0.32607257743127307)},
        {R(0.6699905217924281), R(0.32607257743127307)}, {R(0.9305681557970263), R(0.17392742256872693)},
        {R(0.019855071751231884), R(0.05061426814518813)}, {R(0.10166676129318663), R(0.11119051722668724)},
        {R(0.2372337950418355), R(0.15685332293894363)}, {R(0.4082826787521751), R(0.181341891689181)},
        {R(0.591717321247825), R(0.181341891689181)}, {R(0.7627662049581645), R(0.15685332293894363)},
        {R(0.8983332387068134), R(0.11119051722668724)}, {R(0.9801449282487681), R(0.05061426814518813)}
    };
    const real shortest = SHAPE[0] < SHAPE[1] ? SHAPE[0] : SHAPE[1];
    const bool is_short = way <= R(0.1) * shortest;
    const real x = way / SHAPE[1];
    real sum = R(0);
    int32_t i;
    for (i = is_short ? 0 : 4; i < (is_short ? 4 : 12); i++) {
        const real drawn = anhysteretic(field + sign * way * point[i][0]) - p;
        sum = sum + F(exp)(x * (point[i][0] - R(1))) * drawn * point[i][1];
    }
    return x * sum;
}

/* What the voltage has passed its aim by once the field has moved by `way`: field, p, direction, what is
   left, m_an there. */
static real gone(const rising_function *f, real way, real *slope)
{
    const real field = f->number[0], p = f->number[1], sign = f->number[2];
    const real h = field + sign * way;
    const real moved = relaxed(field, p, sign, way);
    const real drawn = anhysteretic(h);
    const real magnetised = (R(1) - SHAPE[2]) * moved + SHAPE[2] * (drawn - f->number[4]);
    const real frozen = R(1) - SHAPE[3] * SHAPE[2] * anhysteretic_slope(h);
    *slope = frozen - SHAPE[3] * (R(1) - SHAPE[2]) * (drawn - p - moved) * sign / SHAPE[1];
    return way - SHAPE[3] * sign * magnetised - f->number[3];
}

/* What a move changes p by. */
static real branch_increment(real p, real from, real to)
{
    const real sign = to < from ? R(-1) : R(1);
    real field = frozen_field(SHAPE[2], from, p, from), left = sign * (to - from), change = R(0);
    const real shortest = SHAPE[0] < SHAPE[1] ? SHAPE[0] : SHAPE[1];
    real part, panel, slope;
    int32_t count;
    rising_function f;
    if (sign * (anhysteretic(field) - p) < R(0)) {
        /* Frozen until m_an = p. */
        const real frozen = frozen_field(SHAPE[2], to, p, field + (to - from));
        const real low = field < frozen ? field : frozen, high = field < frozen ? frozen : field;
        if (sign * (anhysteretic(frozen) - p) <= R(0)) {
            return R(0);
        }
        f.at = anhysteretic_excess;
        f.number[0] = p;
        field = rising_root(&f, low, high, R(0.5) * low + R(0.5) * high);
        left = sign * (to - (field - SHAPE[3] * p));
    }
    part = (F(fabs)(left) + R(2) * SHAPE[3]) / R(32);
    panel = part > shortest ? part : shortest;
    f.at = gone;
    f.number[2] = sign;
    for (count = 0; count < 32 + 2; count++) {
        real beyond;
        f.number[0] = field;
        f.number[1] = p + change;
        f.number[3] = left;
        f.number[4] = anhysteretic(field);
        beyond = gone(&f, panel, &slope);
        if (beyond < R(0)) {
            change = change + relaxed(field, p + change, sign, panel);
            field = field + sign * panel;
            left = -beyond;
        } else {
            return change + relaxed(field, p + change, sign, rising_root(&f, R(0), panel, left));
        }
    }
    return F(HUGE_VAL);
}

/* What a move to u changes the state by; nothing is lost. */
static real branch_change(const $name_state *state, real u, real *own)
{
    own[0] = branch_increment(state->y[0], state->voltage, u);
    return R(0);
}

/* The magnetisation at u. */
static real branch_output(real p, real u)
{
    return magnetisation(SHAPE[2], frozen_field(SHAPE[2], u, p, u), p);
}

/* p, virgin at u. */
static real branch_virgin(real u)
{
    return anhysteretic(frozen_field(R(1), u, R(0), u));
}
