//{ relaxing
/* How the plays follow a straight line: exp((r - |z|)/SIGMA) obeys a linear equation on it. */
typedef struct {
    real by, size, seconds, shrinks;
} relaxing_move;

/* SIGMA ln(1/SIGMA times the integral of exp(-speed t/SIGMA)) over so many seconds. */
static real shrinkage(real speed, real seconds)
{
    real decay;
    const real reach = relaxation(speed / SIGMA, seconds, &decay);
    return SIGMA * F(log)(reach / SIGMA);
}

static relaxing_move relaxing_move_by(real by, real seconds)
{
    relaxing_move step;
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
static real beyond(const relaxing_move *step, real r, real distance)
{
    const real speed = step->size / step->seconds;
    const real equals = F(log)(speed) * SIGMA + r;
    const real d = F(exp)(-(equals / SIGMA));
    const real passed = (F(log1p)(d) * SIGMA + soft_least(distance, equals)) / speed;
    const real left = not_negative(step->seconds - passed);
    return left <= R(0) ? R(0) : not_negative(soft_least(speed * left, -shrinkage(speed, left) + r));
}

/* The distance behind the drive of a play of half-width r after the move. */
static real relaxing_distance(const relaxing_move *step, real r, real z)
{
    const bool behind = z < R(0) || (z == R(0) && step->by < R(0));
    const real distance = behind ? -z : z, outwards = behind ? -step->by : step->by;
    const real limit = -step->shrinks + r;
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
static real relaxing_output(real p, int32_t i)
{
    const real x = (p - RANGE[0]) * (R(1) / (RANGE[1] - RANGE[0])), span = RANGE[1] - RANGE[0];
    const real inner = x < R(0) ? R(0) : x > R(1) ? R(1) : x;
    const real square = inner * inner, third = square * inner * (R(1) / R(3));
    const real below = x < R(0) ? x : R(0), above = x > R(1) ? x - R(1) : R(0);
    return SLOPE[3 * i] * ((inner - square + third + below) * span)
         + SLOPE[3 * i + 1] * ((square - third * R(2)) * span)
        + SLOPE[3 * i + 2] * ((third + above) * span);
}

/* What the plays put out after a move to u that takes that share of a sample; they go there in `moved`, where
   that is given. */
static real plays_at(const $name_state *state, real u, real share, real *moved)
{
    const real du = u - state->voltage;
    const relaxing_move step = relaxing_move_by(du, state->rested ? F(fabs)(du) : share * INTERVAL);
    real sum = R(0);
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        const real z = relaxing_distance(&step, THRESHOLD[i], state->play[i]);
        sum = sum + relaxing_output(u - z, i);
        if (moved) {
            moved[i] = z;
        }
    }
    return sum;
}

//}
//{ relaxing
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    real sum = R(0);
    int32_t i;
    for (i = 0; i < $NAME_PLAYS; i++) {
        sum = sum + relaxing_output(u, i);
    }
    return polynomial_at($TUNED_FIRSTu) + sum;
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    return polynomial_at($TUNED_FIRSTu) + plays_at(state, u, share, (real *)0);
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    const real out = polynomial_at($TUNED_FIRSTu) + plays_at(state, u, R(1), (real *)0);
    if (!is_in_range(out)) {
        return false;
    }
    (void)plays_at(state, u, R(1), state->play);
    state->rested = false;
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    int32_t i;
    (void)u;
    for (i = 0; i < $NAME_PLAYS; i++) {
        state->play[i] = R(0);
    }
    state->rested = true;
}

//}
