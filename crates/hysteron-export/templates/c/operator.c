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
//{ logs
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

//}
//{ linear_law
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
    const real end = z + change;
    if ((end < R(0) && z > R(0)) || (end > R(0) && z < R(0))) {
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
   Rosenbrock method of order 3 (M. Hochbruck, A. Ostermann, J. Schweitzer 2009, doi:10.1137/080717717), in more where one would go further than
   an eighth of the saturation, |z| held within it. */
static real increment(const bouc_wen *p, real z, real du)
{
    const int down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du, longest = distance * R(0.5);
    const real outwards = p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma;
    const real inwards = p->alpha < R(0) ? p->beta + p->gamma : p->beta - p->gamma;
    const real saturation = F(pow)(F(fabs)(p->alpha) / outwards, R(1) / p->n);
    real bound = F(HUGE_VAL), now = z, change = R(0), left = distance;
    int k;
    if (outwards > R(0) && inwards >= R(0)) {
        bound = F(fabs)(z) > saturation ? F(fabs)(z) : saturation;
    }
    for (k = 1; k <= 32; k++) {
        const real pull = (now < R(0) ? p->beta - turn : p->beta + turn) * F(pow)(F(fabs)(now), p->n - R(1));
        const real f = rise - pull * now;
        const real rate = p->n * pull;
        const real fair = R(0.125) * (F(fabs)(now) > saturation ? F(fabs)(now) : saturation) / F(fabs)(f);
        const real wanted = fair < longest ? fair : longest;
        const real h = wanted < left && k < 32 ? wanted : left;
        real ignored, stage, stage_pull, curve, own, kept;
        const real reach = relaxation(rate, h, &ignored);
        left = left - h;
        stage = held(now + reach * f, bound);
        stage_pull = (stage < R(0) ? p->beta - turn : p->beta + turn) * F(pow)(F(fabs)(stage), p->n - R(1));
        curve = (rise - stage_pull * stage) - f + rate * (stage - now);
        own = reach * f + h * phi3(rate * h) * (curve + curve);
        kept = held(now + own, bound);
        change = kept == now + own ? change + own : kept - z;
        now = kept;
        if (left <= R(0)) {
            break;
        }
    }
    return change;
}

//}
//{ moments
/* m_k(x), the integral of theta^k exp(-x (1 - theta)) from 0 to 1, x >= 0: a series of positive terms, far out the recurrence. */
static void moments(real x, real *m)
{
    const real decay = F(exp)(-x);
    real term = R(1);
    int i, k;
    if (x > R(30)) {
        real last = (-decay + R(1)) / x;
        for (k = 0; k < $N_MOMENTS; k++) {
            if (k > 0) {
                last = (-(last * (real)k) + R(1)) / x;
            }
            m[k] = last;
        }
        return;
    }
    for (k = 0; k < $N_MOMENTS; k++) {
        m[k] = R(0);
    }
    for (i = 0; i < 200; i++) {
        for (k = 0; k < $N_MOMENTS; k++) {
            m[k] = m[k] + term * (R(1) / (real)(i + k + 1));
        }
        term = term * (x * (R(1) / (real)(i + 1)));
        if (F(fabs)(term) <= R(0.0625) * R(EPSILON) * m[$N_MOMENTS - 1]) {
            break;
        }
    }
    for (k = 0; k < $N_MOMENTS; k++) {
        m[k] = decay * m[k];
    }
}

//}
//{ roots
/* A function that rises from one place to another, with what it depends on. */
typedef struct rising_function {
    real (*at)(const struct rising_function *f, real x, real *slope);
    real number[$N_ROOT];
} rising_function;

/* Its zero: Newton's method, a halving where a step leaves the bracket. */
static real rising_root(const rising_function *f, real low, real high, real start)
{
    real x = start < low ? low : start;
    int count;
    x = x > high ? high : x;
    for (count = 0; count < 80; count++) {
        real slope, newton, next;
        const real value = f->at(f, x, &slope);
        if (value == R(0)) {
            return x;
        }
        if (value > R(0)) {
            high = x;
        } else {
            low = x;
        }
        newton = x - value / slope;
        next = low < newton && newton < high ? newton : R(0.5) * (low + high);
        if (F(fabs)(next - x) <= R(2) * R(EPSILON) * F(fabs)(x) || next <= low || next >= high) {
            return next;
        }
        x = next;
    }
    return x;
}

//}
//{ dahl
/* What a move by `by` changes y by. With x = 1 - s y/reach: x <- x exp(-ln(1 + (i - 1) q)/(i - 1)), q = x^(i-1) |by|/reach. */
static real branch_increment(real y, real from, real to)
{
    const real by = to - from;
    const int down = by < R(0);
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

//}
//{ song
/* A move on one side of 0 is one of Bouc-Wen. */
static real one_sided_increment(int negative, real y, real by)
{
    const int down = by < R(0);
    const real b2 = negative ? -SHAPE[1] : SHAPE[1], b3 = negative ? -SHAPE[2] : SHAPE[2];
    const real b6 = negative ? -SHAPE[5] : SHAPE[5];
    const real turned = b3 + SHAPE[4], straight = b2 + SHAPE[3];
    bouc_wen p;
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

//}
//{ non_symmetric
/* What a way t at the rate kappa changes y by. */
static real along(real kappa, real s, real u, real y, real t)
{
    real m[2];
    moments(kappa * t, m);
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
    const int negative = y == R(0) ? drive < R(0) : y < R(0);
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

//}
//{ magnetic
/* L(x) = coth x - 1/x. */
static real langevin(real x)
{
    if (F(fabs)(x) < R(2)) {
        const real square = x * x;
        real tail = R(27);
        int k;
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

/* The field at the voltage u while p stays. */
static real frozen_field(real c, real u, real p)
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
    return rising_root(&f, u - reach, u + reach, u);
}

/* m_an less the p wanted. */
static real anhysteretic_excess(const rising_function *f, real h, real *slope)
{
    *slope = anhysteretic_slope(h);
    return anhysteretic(h) - f->number[0];
}

/* What p changes by while the field moves by `way`, by eight Gauss points. */
static real relaxed(real field, real p, real sign, real way)
{
    static const real point[8][2] = {
        {R(0.019855071751231884), R(0.05061426814518813)}, {R(0.10166676129318663), R(0.11119051722668724)},
        {R(0.2372337950418355), R(0.15685332293894363)}, {R(0.4082826787521751), R(0.181341891689181)},
        {R(0.591717321247825), R(0.181341891689181)}, {R(0.7627662049581645), R(0.15685332293894363)},
        {R(0.8983332387068134), R(0.11119051722668724)}, {R(0.9801449282487681), R(0.05061426814518813)}
    };
    static const real left[8] = {
        R(0.9801449282487681), R(0.8983332387068134), R(0.7627662049581645), R(0.5917173212478248),
        R(0.40828267875217505), R(0.2372337950418355), R(0.10166676129318664), R(0.019855071751231912)
    };
    const real x = way / SHAPE[1];
    real sum = R(0);
    int i;
    for (i = 0; i < 8; i++) {
        const real drawn = anhysteretic(field + sign * way * point[i][0]) - p;
        sum = sum + F(exp)(-(x * left[i])) * drawn * point[i][1];
    }
    return x * sum;
}

/* What the voltage has passed its aim by once the field has moved by `way`: field, p, direction, what is left, m_an there. */
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
    real field = frozen_field(SHAPE[2], from, p), left = sign * (to - from), change = R(0);
    const real shortest = SHAPE[0] < SHAPE[1] ? SHAPE[0] : SHAPE[1];
    real part, panel, slope;
    int count;
    rising_function f;
    if (sign * (anhysteretic(field) - p) < R(0)) {
        /* Frozen until m_an = p. */
        const real frozen = frozen_field(SHAPE[2], to, p);
        const real low = field < frozen ? field : frozen, high = field < frozen ? frozen : field;
        if (sign * (anhysteretic(frozen) - p) <= R(0)) {
            return R(0);
        }
        f.at = anhysteretic_excess;
        f.number[0] = p;
        field = rising_root(&f, low, high, R(0.5) * low + R(0.5) * high);
        left = sign * (to - (field - SHAPE[3] * p));
    }
    part = (F(fabs)(left) + R(2) * SHAPE[3]) / $REAL_PANELS;
    panel = part > shortest ? part : shortest;
    f.at = gone;
    f.number[2] = sign;
    for (count = 0; count < $N_PANELS + 2; count++) {
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

//}
//{ branch
/* What a move to u changes the states by: y[i] by own[i] - lost y[i], lost being handed back. */
static real branch_change(const $name_state *state, real u, real *own)
{
//{ duhem
    const real by = u - state->voltage;
    const real x = SHAPE[0] * F(fabs)(by);
    real a[$NAME_STATES], power = by, ignored;
    int j, k;
    moments(x, a);
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
//}
//{ !duhem
    own[0] = branch_increment(state->y[0], state->voltage, u);
    return R(0);
//}
}

/* What a state puts out at u. */
static real branch_output(real y, real u)
{
//{ magnetic
    return magnetisation(SHAPE[2], frozen_field(SHAPE[2], u, y), y);
//}
//{ !magnetic
    (void)u;
    return y;
//}
}

/* A state, virgin at u. */
static real branch_virgin(real u)
{
//{ magnetic
    return anhysteretic(frozen_field(R(1), u, R(0)));
//}
//{ !magnetic
    (void)u;
    return R(0);
//}
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
//{ sided
/* `state`, pushed as far as its sides push it; at low where they cross. */
static real between(real low, real high, real state)
{
    const real held = state > high ? high : state;
    return held < low ? low : held;
}

//}
//{ ramps
static real ramp(real x)
{
    return between(R(-1), R(1), STEEPNESS * x);
}

//}
//{ line
/* The broken line of the mean of the plays. */
static real line_at(real h)
{
    real sum = h < CORNER[0] ? SLOPE[0] * (h - CORNER[0]) : R(0);
    int i;
    for (i = 1; i < $N_CORNERS; i++) {
        const real inside = h > CORNER[i] ? CORNER[i] : h;
        if (inside > CORNER[i - 1]) {
            sum = sum + SLOPE[i] * (inside - CORNER[i - 1]);
        }
    }
    return h > CORNER[$N_CORNERS - 1] ? sum + SLOPE[$N_CORNERS] * (h - CORNER[$N_CORNERS - 1]) : sum;
}

//}
//{ sided
/* What the plays put out after a monotone move$THROUGH_IN_WORDS to u; they go there in `moved`, where that is given. */
static real plays_at(const $name_state *state, $THROUGH_PARAMETERreal u, real *moved)
{
    real sum = R(0);
//{ line
    real behind = R(0);
//}
//{ rate
    /* First the sides in the middle, then those at the end: upwards the low one at the end decides, downwards the high one. */
    const real wider = WIDENING * F(fabs)(du), above = middle > u ? u : middle, below = middle > u ? middle : u;
//}
//{ envelopes
    const real right = F(tanh)(RIGHT[0] * (u - RIGHT[1])), left = F(tanh)(LEFT[0] * (u - LEFT[1]));
//}
//{ ramps
    real first = ramp(u - THRESHOLD[0]);
    int row = 0, column = 0;
//}
    int i;
//{ envelopes
    if (right - left > R(2) * THRESHOLD[0] + R(4) * R(EPSILON)) {
        return F(HUGE_VAL); /* the narrowest has no place to stand */
    }
//}
    for (i = 0; i < $NAME_PLAYS; i++) {
//{ even
        const real low = u - THRESHOLD[i], high = u + THRESHOLD[i];
//}
//{ rate
        const real r = THRESHOLD[i] + wider, high = above + r;
        const real low = middle > u && below - r > high ? high : below - r;
//}
//{ below
        const real low = u - THRESHOLD[i], high = u;
//}
//{ envelopes
        const real low = right - THRESHOLD[i], high = left + THRESHOLD[i];
//}
//{ ramps
        const real low = first, high = ramp(u - THRESHOLD[column]);
//}
        const real stands = between(low, high, state->play[i]);
        sum = sum + K(weight)[i] * stands;
//{ line
        behind = behind + SHARE[i] * (stands - u);
//}
        if (moved) {
            moved[i] = stands;
        }
//{ ramps
        if (++column > row) {
            row++;
            column = 0;
            first = row < $N_THRESHOLDS ? ramp(u - THRESHOLD[row]) : R(0);
        }
//}
    }
//{ line
    return sum + line_at(u + behind);
//}
//{ !line
    return sum;
//}
}

/* Where play number i is virgin at u. */
static real virgin_play(real u, int i)
{
//{ even|rate|below
    (void)i;
    return u;
//}
//{ envelopes
    (void)i;
    return R(0.5) * (F(tanh)(RIGHT[0] * (u - RIGHT[1])) + F(tanh)(LEFT[0] * (u - LEFT[1])));
//}
//{ ramps
    int row = 0;
    while (i > row) {
        row++;
        i -= row;
    }
    return ramp(u - (R(0.5) * THRESHOLD[row] + R(0.5) * THRESHOLD[i]));
//}
}

//}
//{ activated
/* How the plays follow a straight line: exp((r - |z|)/SIGMA) obeys a linear equation on it. */
typedef struct {
    real by, size, seconds, shrinks;
} activated_move;

/* SIGMA ln(1/SIGMA times the integral of exp(-speed t/SIGMA)) over so many seconds. */
static real shrinkage(real speed, real seconds)
{
    real decay;
    const real reach = relaxation(speed / SIGMA, seconds, &decay);
    return SIGMA * F(log)(reach / SIGMA);
}

static activated_move activated_move_by(real by, real seconds)
{
    activated_move step;
    step.by = by;
    step.size = F(fabs)(by);
    step.seconds = seconds;
    step.shrinks = seconds > R(0) ? shrinkage(step.size / seconds, seconds) : R(0);
    return step;
}

/* -SIGMA ln(exp(-a/SIGMA) + exp(-b/SIGMA)). */
static real soft_least(real a, real b)
{
    const real less = a < b ? a : b, more = a < b ? b : a;
    const real apart = (more - less) / SIGMA;
    return apart > R(38) ? less : less - F(log1p)(F(exp)(-apart)) * SIGMA;
}

static real not_negative(real x)
{
    return x < R(0) ? R(0) : x;
}

/* The distance to the other side of a play that the drive passes on its way. */
static real beyond(const activated_move *step, real r, real distance)
{
    const real speed = step->size / step->seconds;
    const real equals = F(log)(speed) * SIGMA + r;
    const real d = F(exp)(-(equals / SIGMA));
    const real passed = (F(log1p)(d) * SIGMA + soft_least(distance, equals)) / speed;
    const real left = not_negative(step->seconds - passed);
    return left <= R(0) ? R(0) : not_negative(soft_least(speed * left, -shrinkage(speed, left) + r));
}

/* The distance behind the drive of a play of half-width r after the move. */
static real activated_distance(const activated_move *step, real r, real z)
{
    const int behind = z < R(0) || (z == R(0) && step->by < R(0));
    const real distance = behind ? -z : z, outwards = behind ? -step->by : step->by, limit = -step->shrinks + r;
    real left;
    if (!(step->seconds > R(0))) {
        return z + step->by;
    }
    if (!(outwards < R(0))) {
        left = not_negative(soft_least(distance + step->size, limit));
        return behind ? -left : left;
    }
    left = soft_least(distance, limit) - step->size;
    if (left >= R(0)) {
        return behind ? -left : left;
    }
    left = beyond(step, r, distance);
    return behind ? left : -left;
}

/* What a play puts out that stands at p: slopes over the range, straight beyond its ends. */
static real activated_output(real p, int i)
{
    const real x = (p - RANGE[0]) * (R(1) / (RANGE[1] - RANGE[0])), span = RANGE[1] - RANGE[0];
    const real inner = x < R(0) ? R(0) : x > R(1) ? R(1) : x;
    const real square = inner * inner, third = square * inner * (R(1) / R(3));
    const real below = x < R(0) ? x : R(0), above = x > R(1) ? x - R(1) : R(0);
    return SLOPE[3 * i] * ((inner - square + third + below) * span) + SLOPE[3 * i + 1] * ((square - third * R(2)) * span)
        + SLOPE[3 * i + 2] * ((third + above) * span);
}

/* What the plays put out after a move to u that takes that share of a sample; they go there in `moved`, where that is given. */
static real plays_at(const $name_state *state, real u, real share, real *moved)
{
    const real du = u - state->voltage;
    const activated_move step = activated_move_by(du, state->rested ? F(fabs)(du) : share * INTERVAL);
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        const real z = activated_distance(&step, THRESHOLD[i], state->play[i]);
        sum = sum + activated_output(u - z, i);
        if (moved) {
            moved[i] = z;
        }
    }
    return sum;
}

//}
//{ plane
/* Half of the Everett function at levels p and q: weight of the relays that switch between them. */
static real node(int p, int q)
{
    return p <= q ? R(0) : EVERETT[p * (p - 1) / 2 + q];
}

/* u in intervals from the lowest level. */
static real scaled(real u)
{
    return (u - LOWEST) * DENSITY;
}

/* The interval of x, held to the levels, and the share of it passed. */
static int place(real x, real *share)
{
    int interval;
    x = x > $REAL_INTERVALS ? $REAL_INTERVALS : x;
    x = x > R(0) ? x : R(0);
    interval = (int)x;
    interval = interval > $N_INTERVALS - 1 ? $N_INTERVALS - 1 : interval;
    *share = x - (real)interval;
    return interval;
}

/* Half of the Everett function at alpha >= beta, scaled: bilinear, in the interval of the diagonal linear. */
static real weight_between(real alpha, real beta)
{
    real a, b, first, second;
    const int i = place(alpha, &a), j = place(beta, &b);
    if (i == j) {
        return node(i + 1, i) * (a - b);
    }
    first = node(i, j) + b * (node(i, j + 1) - node(i, j));
    second = node(i + 1, j) + b * (node(i + 1, j + 1) - node(i + 1, j));
    return first + a * (second - first);
}

/* Of the plane, or of the plane mirrored at an antidiagonal. */
static real mirror_node(int mirrored, int p, int q)
{
    return mirrored ? node($N_INTERVALS - q, $N_INTERVALS - p) : node(p, q);
}

/* Weight of the relays with alpha up to `to` above the antidiagonal through `rest`: along it, cell by cell. */
static real virgin_weight(int mirrored, real rest, real to)
{
    real x = rest > R(0) ? rest : R(0), share, sum = R(0), row, column;
    int i, j, below, count;
    to = to > $REAL_INTERVALS ? $REAL_INTERVALS : to;
    i = place(x, &share);
    j = place(rest + rest - x, &share);
    row = (real)i;
    column = (real)j;
    below = rest + rest - x <= R(0);
    for (count = 0; count < 2 * $N_INTERVALS + 2; count++) {
        const real row_end = row + R(1), column_end = rest + rest - column;
        const int by_column = !below && column_end < row_end;
        real end = by_column ? column_end : row_end;
        if (x >= to || i >= $N_INTERVALS) {
            break;
        }
        end = end < to ? end : to;
        if (end > x) {
            const real middle = R(0.5) * (x + end);
            const real beta = below ? R(0) : rest + rest - middle;
            real slope;
            if (i == j) {
                slope = mirror_node(mirrored, i + 1, i);
            } else {
                const real b = below ? R(0) : beta - column;
                const real first = mirror_node(mirrored, i + 1, j) - mirror_node(mirrored, i, j);
                const real second = mirror_node(mirrored, i + 1, j + 1) - mirror_node(mirrored, i, j + 1);
                slope = first + b * (second - first);
            }
            sum = sum + (end - x) * slope;
            x = end;
        }
        if (by_column) {
            below = j == 0;
            j -= j > 0;
            column = (real)j;
        } else {
            i++;
            row = row + R(1);
        }
    }
    return sum;
}

/* What the plane puts out where it is virgin at u. */
static real plane_at_rest(real u)
{
    return node($N_INTERVALS, 0) - R(2) * virgin_weight(0, scaled(u), $REAL_INTERVALS);
}

/* A move that has been looked at: turns left at its end, and what the plane puts out there. */
typedef struct {
    int left;
    real output;
} plane_move;

/* A turn; the present place behind those that are kept. */
static real turn_voltage(const $name_state *state, int index)
{
    return index < state->kept ? state->turn_voltage[index] : state->voltage;
}

/* A loop ends where it began, the widest where the virgin curve does. */
static plane_move plane_look(const $name_state *state, real u)
{
    const int rising = u > state->voltage;
    plane_move to;
    to.left = state->kept;
    to.output = state->plane;
    if (u == state->voltage) {
        return to;
    }
    to.left += state->moved && state->rising != rising;
    while (to.left > 1 && (rising ? u >= turn_voltage(state, to.left - 2) : u <= turn_voltage(state, to.left - 2))) {
        to.left -= 2;
    }
    if (to.left == 1) {
        const real limit = R(2) * state->virgin - turn_voltage(state, 0);
        if (rising ? u >= limit : u <= limit) {
            to.left = 0;
        }
    }
    if (to.left == 0) {
        const real rest = scaled(state->virgin), end = scaled(u);
        to.output = state->plane_virgin
                    + (end > rest ? R(2) * virgin_weight(0, rest, end)
                                  : R(-2) * virgin_weight(1, $REAL_INTERVALS - rest, $REAL_INTERVALS - end));
    } else {
        const int last = to.left - 1;
        const real turn = turn_voltage(state, last);
        to.output = (last < state->kept ? state->turn_output[last] : state->plane)
                    + (u > turn ? R(2) * weight_between(scaled(u), scaled(turn))
                                : R(-2) * weight_between(scaled(turn), scaled(u)));
    }
    return to;
}

/* Makes room for a turn at the present place: of the pairs of neighbours between two others, the one that least lies between is forgotten. */
static void forget_turns($name_state *state)
{
    real least = F(HUGE_VAL);
    int at = 1, i;
    for (i = 0; i + 3 <= $NAME_TURNS; i++) {
        const real across = F(fabs)(state->turn_voltage[i] - state->turn_voltage[i + 2]);
        const real size = across * F(fabs)(turn_voltage(state, i + 3) - state->turn_voltage[i + 1]);
        if (size < least) {
            least = size;
            at = i + 1;
        }
    }
    for (i = at; i + 2 < state->kept; i++) {
        state->turn_voltage[i] = state->turn_voltage[i + 2];
        state->turn_output[i] = state->turn_output[i + 2];
    }
    state->kept -= 2;
}

/* Makes a move that has been looked at; the voltage is still that before it. */
static void plane_make($name_state *state, plane_move to, real u)
{
    if (u == state->voltage) {
        return;
    }
    if (to.left > state->kept) {
        if (state->kept >= $NAME_TURNS) {
            forget_turns(state);
        }
        state->turn_voltage[state->kept] = state->voltage;
        state->turn_output[state->kept] = state->plane;
        state->kept++;
    } else {
        state->kept = to.left;
    }
    state->moved = 1;
    state->rising = u > state->voltage;
    state->plane = to.output;
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
//{ sided
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * virgin_play(u, i);
    }
//{ envelopes
    if (F(tanh)(RIGHT[0] * (u - RIGHT[1])) - F(tanh)(LEFT[0] * (u - LEFT[1])) > R(2) * THRESHOLD[0] + R(4) * R(EPSILON)) {
        return F(HUGE_VAL); /* the narrowest has no place to stand */
    }
//}
//{ line
    sum = sum + line_at(u);
//}
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ activated
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + activated_output(u, i);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ plane
    return polynomial_at($TUNED_FIRSTu) + plane_at_rest(u);
//}
//{ branch
    const real state_there = branch_virgin(u);
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_STATES; i++) {
        sum = sum + K(weight)[i] * branch_output(state_there, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ bouc_wen|memoryless
    return polynomial_at($TUNED_FIRSTu);
//}
}

//{ looks
/* What a monotone move to u would put out$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
//{ bouc_wen
    real v = polynomial_at($TUNED_FIRSTu);
    int i;
    for (i = 0; i < $NAME_OPERATORS; i++) {
        v = v - (state->z[i] + increment(&K(operators)[i], state->z[i], u - state->voltage));
    }
    return v;
//}
//{ plays
    real sum = R(0);
    int i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + K(weight)[i] * play(THRESHOLD[i], state->play[i], u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, state->rested ? R(0) : du, u, (real *)0);
//}
//{ sided
//{ !rate
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, (real *)0);
//}
//}
//{ activated
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, share, (real *)0);
//}
//{ plane
    return polynomial_at($TUNED_FIRSTu) + plane_look(state, u).output;
//}
//{ branch
    real own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
    int i;
    for (i = 0; i < $NAME_STATES; i++) {
        const real y = state->y[i] + (own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y, u);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
//}
//{ memoryless
    return polynomial_at($TUNED_FIRSTu);
//}
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
//{ plane
    const plane_move to = plane_look(state, u);
//}
//{ branch
    real y[$NAME_STATES], y_carry[$NAME_STATES], own[$NAME_STATES], sum = R(0);
    const real lost = branch_change(state, u, own);
//}
//{ rate
    const real du = state->rested ? R(0) : u - state->voltage;
//{ means
    const real middle = R(0.5) * state->voltage + R(0.5) * u;
//}
//{ !means
    const real middle = u;
//}
//}
//{ bouc_wen|plays|branch
    int i;
//}
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
//{ rate
    out = out + plays_at(state, middle, du, u, (real *)0);
//}
//{ sided
//{ !rate
    out = out + plays_at(state, u, (real *)0);
//}
//}
//{ activated
    out = out + plays_at(state, u, R(1), (real *)0);
//}
//{ plane
    out = out + to.output;
//}
//{ branch
    for (i = 0; i < $NAME_STATES; i++) {
        y[i] = state->y[i];
        y_carry[i] = state->y_carry[i];
        accumulate(&y[i], &y_carry[i], own[i] - lost * state->y[i]);
        sum = sum + K(weight)[i] * branch_output(y[i], u);
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
//{ rate
    (void)plays_at(state, middle, du, u, state->play);
    state->rested = 0;
//}
//{ sided
//{ !rate
    (void)plays_at(state, u, state->play);
//}
//}
//{ activated
    (void)plays_at(state, u, R(1), state->play);
    state->rested = 0;
//}
//{ plane
    plane_make(state, to, u);
//}
//{ branch
    for (i = 0; i < $NAME_STATES; i++) {
        state->y[i] = y[i];
        state->y_carry[i] = y_carry[i];
    }
//}
    state->voltage = u;
    *v = out;
    return 1;
}

