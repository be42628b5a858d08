/* Neither infinite nor NaN. */
static int is_finite(real x)
{
    return F(fabs)(x) <= R(MAX);
}

/* Whether the dynamics can be fed with v: from there on they stay within the range of the number type. */
static int is_in_range(real v)
{
    return F(fabs)(v) <= R(LARGEST);
}

//{ accumulates
/* x + delta without losing what is smaller than half a unit of x (W. Kahan 1965, doi:10.1145/363707.363723). */
static void accumulate(real *x, real *carry, real delta)
{
    const real more = delta + *carry;
    const real sum = *x + more;
    *carry = more - (sum - *x);
    *x = sum;
}

//}
//{ relaxes
/* G(x) = (exp(-x) - 1 + x)/x^2 where |x| <= 1/2, by its series; 0 where x is larger, and *g is not set. */
static int small_remainder(real x, real *g)
{
    const real size = F(fabs)(x);
    if (size <= R(SMALL)) {
        const real x2 = x * x;
        *g = ((x * R(-1/6) + R(1/2)) + (x * R(-1/120) + R(1/24)) * x2)
             + (x * R(-1/5040) + R(1/720)) * (x2 * x2);
        return 1;
    }
    if (size <= R(0.5)) {
        const real x2 = x * x;
        const real x4 = x2 * x2;
        const real low = (x * R(-1/6) + R(1/2)) + (x * R(-1/120) + R(1/24)) * x2;
        const real middle = (x * R(-1/5040) + R(1/720)) + (x * R(-1/362880) + R(1/40320)) * x2;
        const real high = ((x * R(-1/39916800) + R(1/3628800))
                           + (x * R(-1/6227020800) + R(1/479001600)) * x2)
                          + x4 * R(1/87178291200);
        *g = low + (middle + high * x4) * x4;
        return 1;
    }
    return 0;
}

/* (1 - exp(-kappa d))/kappa, which is d where kappa is 0; *decay = exp(-kappa d). */
static real relaxation(real kappa, real d, real *decay)
{
    const real x = kappa * d;
    real g;
    if (small_remainder(x, &g)) {
        const real ratio = -(x * g) + R(1);
        *decay = -(x * ratio) + R(1);
        return d * ratio;
    }
    *decay = F(exp)(-x);
    return (-*decay + R(1)) / kappa;
}

//}
//{ linear_law
/* ln(1 + kappa r)/kappa, which is r where kappa is 0. */
static real log_distance(real kappa, real r)
{
    const real y = kappa * r;
    if (F(fabs)(y) <= R(0.001)) {
        real ratio = R(1/6);
        ratio = -(ratio * y) + R(1/5);
        ratio = -(ratio * y) + R(1/4);
        ratio = -(ratio * y) + R(1/3);
        ratio = -(ratio * y) + R(1/2);
        ratio = -(ratio * y) + R(1);
        return r * ratio;
    }
    return F(log1p)(y) / kappa;
}

/* z after a move by du that passes through 0: there dz/d|u| = s alpha - kappa z changes its kappa. */
static real move_through_zero(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du;
    const real lead = z == R(0) ? rise : z;
    const real kappa = lead < R(0) ? p->beta - turn : p->beta + turn;
    real decay, reach, end, rest, ignored;
    reach = relaxation(kappa, distance, &decay);
    end = z * decay + rise * reach;
    if (z == R(0) || (end < R(0)) == (z < R(0)) || rise == R(0)) {
        return end;
    }
    rest = distance - log_distance(kappa, -(z / rise));
    if (rest <= R(0)) {
        return rise * rest;
    }
    return rise * relaxation(p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma, rest, &ignored);
}

/* What a monotone move by du changes z by, without the cancellation of a difference:
   dz = (s alpha - kappa z) (1 - exp(-kappa |du|))/kappa, kappa = beta + s gamma sign z. */
static real increment(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du;
    const real lead = z == R(0) ? rise : z;
    const real kappa = lead < R(0) ? p->beta - turn : p->beta + turn;
    real ignored;
    const real reach = relaxation(kappa, distance, &ignored);
    const real change = (rise - kappa * z) * reach;
    if ((z + change) * z < R(0)) {
        return move_through_zero(p, z, du) - z;
    }
    return change;
}

//}
//{ quadratic_law
/* tanh(h sqrt(a kappa))/sqrt(a kappa), and as it continues where a kappa <= 0; 0 where the tangent has gone through its pole, and *t
   is not set. */
static int tangent(real a, real kappa, real h, real *t)
{
    const real y = (a * h) * (kappa * h);
    real root, angle;
    if (F(fabs)(y) <= R(0.015625)) {
        real ratio = R(-929569/638512875);
        ratio = ratio * y + R(21844/6081075);
        ratio = ratio * y + R(-1382/155925);
        ratio = ratio * y + R(62/2835);
        ratio = ratio * y + R(-17/315);
        ratio = ratio * y + R(2/15);
        ratio = ratio * y + R(-1/3);
        ratio = ratio * y + R(1);
        *t = h * ratio;
        return 1;
    }
    root = F(sqrt)(F(fabs)(a)) * F(sqrt)(F(fabs)(kappa));
    angle = root * h;
    if ((a > R(0)) == (kappa > R(0))) {
        *t = F(tanh)(angle) / root;
        return 1;
    }
    if (angle >= R(HALF_PI)) {
        return 0;
    }
    *t = F(tan)(angle) / root;
    return 1;
}

/* The h at which `tangent` is t. */
static real inverse_tangent(real a, real kappa, real t)
{
    const real y = (a * t) * (kappa * t);
    real root, x;
    if (F(fabs)(y) <= R(0.001)) {
        real ratio = R(1/11);
        ratio = ratio * y + R(1/9);
        ratio = ratio * y + R(1/7);
        ratio = ratio * y + R(1/5);
        ratio = ratio * y + R(1/3);
        ratio = ratio * y + R(1);
        return t * ratio;
    }
    root = F(sqrt)(F(fabs)(a)) * F(sqrt)(F(fabs)(kappa));
    x = root * t;
    if ((a > R(0)) == (kappa > R(0))) {
        return F(log1p)((x * R(2)) / (-x + R(1))) * R(0.5) / root;
    }
    return F(atan)(x) / root;
}

typedef enum { LEG_END, LEG_ZERO, LEG_UNBOUNDED } leg_kind;

/* Moves w = |z| >= 0 by the distance h, dw/dh = a - kappa w^2. *end is w there, or what is left of h where w has come to 0. */
static leg_kind leg(real a, real kappa, real w, real h, real *end)
{
    real top = R(0), bottom = R(0), t, slope;
    if (tangent(a, kappa, h, &t)) {
        if (!is_finite(t)) {
            return LEG_UNBOUNDED;
        }
        top = w + a * t;
        bottom = kappa * w * t + R(1);
        if (bottom > R(0) && (top >= R(0) || w <= R(0))) {
            *end = top / bottom;
            return LEG_END;
        }
    } else if (a < R(0)) {
        bottom = R(1);
    } else {
        top = R(1);
    }
    slope = a - kappa * w * w;
    if (bottom <= R(0) && (top > R(0) || slope > R(0))) {
        return LEG_UNBOUNDED;
    }
    if (slope == R(0)) {
        *end = w;
        return LEG_END;
    }
    *end = h - inverse_tangent(a, kappa, -(w / a));
    return LEG_ZERO;
}

/* z after a move by du that passes through 0; infinite where it has no bound. */
static real move_through_zero(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real lead = z == R(0) ? rise : z;
    const int negative = lead < R(0);
    const real kappa = down == negative ? p->beta + p->gamma : p->beta - p->gamma;
    real end = R(0);
    if (du == R(0)) {
        return z;
    }
    switch (leg(negative ? -rise : rise, kappa, negative ? -z : z, F(fabs)(du), &end)) {
    case LEG_END:
        return negative ? -end : end;
    case LEG_ZERO:
        if (leg(F(fabs)(p->alpha), p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma, R(0), end, &end)
            != LEG_UNBOUNDED) {
            return rise < R(0) ? -end : end;
        }
        break;
    case LEG_UNBOUNDED:
    default:
        break;
    }
    return F(HUGE_VAL);
}

/* What a monotone move by du changes z by, without the cancellation of a difference: with w = |z| and dw/d|u| = a - kappa w^2,
   dw = T (a - kappa w^2)/(1 + kappa w T), T = tanh(|du| sqrt(a kappa))/sqrt(a kappa). */
static real increment(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real lead = z == R(0) ? rise : z;
    const int negative = lead < R(0);
    const real kappa = down == negative ? p->beta + p->gamma : p->beta - p->gamma;
    const real a = negative ? -rise : rise;
    const real w = negative ? -z : z;
    real t;
    if (tangent(a, kappa, F(fabs)(du), &t)) {
        const real below = R(1) + kappa * w * t;
        const real change = t * (a - kappa * w * w) / below;
        if (below > R(0) && w + change >= R(0) && is_finite(change)) {
            return negative ? -change : change;
        }
    }
    return move_through_zero(p, z, du) - z;
}

//}
//{ power_law
/* phi_3(-x) = (1/2 - (1 - (1 - exp(-x))/x)/x)/x. */
static real phi3(real x)
{
    static const real factorial[10] = {
        R(1/6), R(1/24), R(1/120), R(1/720), R(1/5040),
        R(1/40320), R(1/362880), R(1/3628800), R(1/39916800), R(1/479001600)
    };
    real phi1, phi2, ignored;
    if (F(fabs)(x) <= R(0.5)) {
        real sum = R(0);
        int k;
        for (k = 9; k >= 0; k--) {
            sum = factorial[k] - x * sum;
        }
        return sum;
    }
    phi1 = relaxation(x, R(1), &ignored);
    phi2 = (R(1) - phi1) / x;
    return (R(0.5) - phi2) / x;
}

static real held(real z, real bound)
{
    if (z > bound) {
        return bound;
    }
    if (z < -bound) {
        return -bound;
    }
    return z;
}

/* What a monotone move by du changes z by: dz/d|u| = s alpha - (beta + s gamma sign z) z |z|^(n-1) in two steps of an exponential
   Rosenbrock method of order 3 (M. Hochbruck, A. Ostermann, J. Schweitzer 2009, doi:10.1137/080717717), |z| held within its saturation. */
static real increment(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real h = (down ? -du : du) * R(0.5);
    const real outwards = p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma;
    const real inwards = p->alpha < R(0) ? p->beta + p->gamma : p->beta - p->gamma;
    const real saturation = F(pow)(F(fabs)(p->alpha) / outwards, R(1) / p->n);
    real bound = F(HUGE_VAL), now = z, change = R(0);
    int k;
    if (outwards > R(0) && inwards >= R(0)) {
        bound = F(fabs)(z) > saturation ? F(fabs)(z) : saturation;
    }
    for (k = 0; k < 2; k++) {
        const real pull = (now < R(0) ? p->beta - turn : p->beta + turn) * F(pow)(F(fabs)(now), p->n - R(1));
        const real f = rise - pull * now;
        const real rate = p->n * pull;
        real ignored, stage, stage_pull, curve, own, kept;
        const real reach = relaxation(rate, h, &ignored);
        stage = held(now + reach * f, bound);
        stage_pull = (stage < R(0) ? p->beta - turn : p->beta + turn) * F(pow)(F(fabs)(stage), p->n - R(1));
        curve = (rise - stage_pull * stage) - f + rate * (stage - now);
        own = reach * f + h * phi3(rate * h) * (curve + curve);
        kept = held(now + own, bound);
        change = kept == now + own ? change + own : kept - z;
        now = kept;
    }
    return change;
}

//}
//{ plays
/* A play of half-width r after a monotone move of its input to u. */
static real play(real r, real state, real u)
{
    const real low = u - r, high = u + r;
    const real kept = state > high ? high : state;
    return kept < low ? low : kept;
}

//}
/* The polynomial l[u]. */
static real polynomial_at($TUNED_AS_ARGUMENT_FIRSTreal u)
{
//{ polynomial
    real sum = R(0);
    int i;
    for (i = $N_POLYNOMIAL - 1; i >= 0; i--) {
        sum = (sum + K(polynomial)[i]) * u;
    }
    return sum;
//}
//{ !polynomial
//{ tunable
    (void)state;
//}
    (void)u;
    return R(0);
//}
}

/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
//{ plays
    real v = polynomial_at($TUNED_FIRSTu);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        v = v + K(weight)[i] * u;
    }
    return v;
//}
//{ !plays
    return polynomial_at($TUNED_FIRSTu);
//}
}

//{ looks
/* What a monotone move to u would put out; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u)
{
    real v = polynomial_at($TUNED_FIRSTu);
    int i;
//{ bouc_wen
    for (i = 0; i < $NAME_OPERATORS; i++) {
        v = v - (state->z[i] + increment(&K(operators)[i], state->z[i], u - state->voltage));
    }
//}
//{ plays
    for (i = 0; i < $NAME_PLAYS; i++) {
        v = v + K(weight)[i] * play(THRESHOLD[i], state->play[i], u);
    }
//}
    return v;
}

//}
/* Moves monotonically to u: *v is what the hysteresis puts out there. 0, and nothing has moved, where that is out of range. */
static int hysteresis_move($name_state *state, real u, real *v)
{
//{ bouc_wen
    real z[$NAME_OPERATORS], z_carry[$NAME_OPERATORS];
    const real du = u - state->voltage;
//}
//{ plays
    real moved[$NAME_PLAYS], sum = R(0);
//}
    int i;
    real out = polynomial_at($TUNED_FIRSTu);
//{ bouc_wen
    for (i = 0; i < $NAME_OPERATORS; i++) {
        z[i] = state->z[i];
        z_carry[i] = state->z_carry[i];
        accumulate(&z[i], &z_carry[i], increment(&K(operators)[i], state->z[i], du));
        out = out - z[i];
    }
//}
//{ plays
    for (i = 0; i < $NAME_PLAYS; i++) {
        moved[i] = play(THRESHOLD[i], state->play[i], u);
        sum = sum + K(weight)[i] * moved[i];
    }
    out = out + sum;
//}
    if (!is_in_range(out)) {
        return 0;
    }
//{ bouc_wen
    for (i = 0; i < $NAME_OPERATORS; i++) {
        state->z[i] = z[i];
        state->z_carry[i] = z_carry[i];
    }
//}
//{ plays
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = moved[i];
    }
//}
    state->voltage = u;
    *v = out;
    return 1;
}

