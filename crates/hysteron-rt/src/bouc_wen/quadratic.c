//{ quadratic_law
/* tanh(h sqrt(a kappa))/sqrt(a kappa), and as it continues where a kappa <= 0; 0 where the tangent has gone
   through its pole, and *t is not set. */
static bool tangent(real a, real kappa, real h, real *t)
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
        return true;
    }
    root = F(sqrt)(F(fabs)(a)) * F(sqrt)(F(fabs)(kappa));
    angle = root * h;
    if ((a > R(0)) == (kappa > R(0))) {
        *t = F(tanh)(angle) / root;
        return true;
    }
    if (angle >= R(HALF_PI)) {
        return false;
    }
    *t = F(tan)(angle) / root;
    return true;
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

/* Moves w = |z| >= 0 by the distance h, dw/dh = a - kappa w^2. *end is w there, or what is left of h where w
   has come to 0. */
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
static real move_through_zero(const state_law *p, real z, real du)
{
    const bool down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real lead = z == R(0) ? rise : z;
    const bool negative = lead < R(0);
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

/* What a monotone move by du changes z by, without the cancellation of a difference: with w = |z| and
   dw/d|u| = a - kappa w^2, dw = T (a - kappa w^2)/(1 + kappa w T),
   T = tanh(|du| sqrt(a kappa))/sqrt(a kappa). */
static real increment(const state_law *p, real z, real du)
{
    const bool down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real lead = z == R(0) ? rise : z;
    const bool negative = lead < R(0);
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
