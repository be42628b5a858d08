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
        int32_t k;
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

/* What a monotone move by du changes z by: dz/d|u| = s alpha - (beta + s gamma sign z) z |z|^(n-1) in two
   steps of an exponential Rosenbrock method of order 3 (M. Hochbruck, A. Ostermann, J. Schweitzer 2009,
   doi:10.1137/080717717), in more where one would go further than an eighth of the saturation, |z| held
   within it. */
static real increment(const state_law *p, real z, real du)
{
    const bool down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du, longest = distance * R(0.5);
    const real outwards = p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma;
    const real inwards = p->alpha < R(0) ? p->beta + p->gamma : p->beta - p->gamma;
    const real saturation = F(pow)(F(fabs)(p->alpha) / outwards, R(1) / p->n);
    real bound = F(HUGE_VAL), now = z, change = R(0), left = distance;
    int32_t k;
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
