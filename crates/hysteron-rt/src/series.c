//{ relaxes
/* G(x) = (exp(-x) - 1 + x)/x^2 where |x| <= 1/2, by its series; 0 where x is larger, and *g is not set. */
static bool small_remainder(real x, real *g)
{
    const real size = F(fabs)(x);
    if (size <= R(SMALL)) {
        const real x2 = x * x;
        *g = ((x * R(-1/6) + R(1/2)) + (x * R(-1/120) + R(1/24)) * x2)
             + (x * R(-1/5040) + R(1/720)) * (x2 * x2);
        return true;
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
        return true;
    }
    return false;
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
