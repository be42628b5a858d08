//{ plane
/* Half of the Everett function at levels p and q: weight of the relays that switch between them. */
static real node(int32_t p, int32_t q)
{
    return p <= q ? R(0) : EVERETT[p * (p - 1) / 2 + q];
}

/* u in intervals from the lowest level. */
static real scaled(real u)
{
    return (u - LOWEST) * DENSITY;
}

/* The interval of x, held to the levels, and the share of it passed. */
static int32_t place(real x, real *share)
{
    int32_t interval;
    x = x > $REAL_INTERVALS ? $REAL_INTERVALS : x;
    x = x > R(0) ? x : R(0);
    interval = (int32_t)x;
    interval = interval > $N_INTERVALS - 1 ? $N_INTERVALS - 1 : interval;
    *share = x - (real)interval;
    return interval;
}

/* Half of the Everett function at alpha >= beta, scaled: bilinear, in the interval of the diagonal linear. */
static real weight_between(real alpha, real beta)
{
    real a, b, first, second;
    const int32_t i = place(alpha, &a), j = place(beta, &b);
    if (i == j) {
        return node(i + 1, i) * (a - b);
    }
    first = node(i, j) + b * (node(i, j + 1) - node(i, j));
    second = node(i + 1, j) + b * (node(i + 1, j + 1) - node(i + 1, j));
    return first + a * (second - first);
}

/* Of the plane, or of the plane mirrored at an antidiagonal. */
static real mirror_node(bool mirrored, int32_t p, int32_t q)
{
    return mirrored ? node($N_INTERVALS - q, $N_INTERVALS - p) : node(p, q);
}

/* Weight of the relays with alpha up to `to` above the antidiagonal through `rest`: along it, cell by
   cell. */
static real virgin_weight(bool mirrored, real rest, real to)
{
    real x = rest > R(0) ? rest : R(0), share, sum = R(0), row, column;
    bool below;
    int32_t i, j, count;
    to = to > $REAL_INTERVALS ? $REAL_INTERVALS : to;
    i = place(x, &share);
    j = place(rest + rest - x, &share);
    row = (real)i;
    column = (real)j;
    below = rest + rest - x <= R(0);
    for (count = 0; count < 2 * $N_INTERVALS + 2; count++) {
        const real row_end = row + R(1), column_end = rest + rest - column;
        const bool by_column = !below && column_end < row_end;
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
            j -= j > 0 ? 1 : 0;
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
    return node($N_INTERVALS, 0) - R(2) * virgin_weight(false, scaled(u), $REAL_INTERVALS);
}

/* A move that has been looked at: turns left at its end, and what the plane puts out there. */
typedef struct {
    int32_t left;
    real output;
} plane_move;

/* A turn; the present place behind those that are kept. */
static real turn_voltage(const $name_state *state, int32_t index)
{
    return index < state->kept ? state->turn_voltage[index] : state->voltage;
}

/* A loop ends where it began, the widest where the virgin curve does. */
static plane_move plane_look(const $name_state *state, real u)
{
    const bool rising = u > state->voltage;
    plane_move to;
    to.left = state->kept;
    to.output = state->plane;
    if (u == state->voltage) {
        return to;
    }
    to.left += state->moved && state->rising != rising ? 1 : 0;
    while (to.left > 1 && (rising ? u >= turn_voltage(state, to.left - 2)
                                  : u <= turn_voltage(state, to.left - 2))) {
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
                    + (end > rest
                           ? R(2) * virgin_weight(false, rest, end)
                           : R(-2) * virgin_weight(true, $REAL_INTERVALS - rest, $REAL_INTERVALS - end));
    } else {
        const int32_t last = to.left - 1;
        const real turn = turn_voltage(state, last);
        to.output = (last < state->kept ? state->turn_output[last] : state->plane)
                    + (u > turn ? R(2) * weight_between(scaled(u), scaled(turn))
                                : R(-2) * weight_between(scaled(turn), scaled(u)));
    }
    return to;
}

/* Makes room for a turn at the present place: of the pairs of neighbours between two others, the one that
   least lies between is forgotten. */
static void forget_turns($name_state *state)
{
    real least = F(HUGE_VAL);
    int32_t at = 1, i;
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
    state->moved = true;
    state->rising = u > state->voltage;
    state->plane = to.output;
}

//}
//{ plane
/* The hysteresis, virgin at u. */
static real hysteresis_at_rest($TUNED_AS_ARGUMENT_FIRSTreal u)
{
    return polynomial_at($TUNED_FIRSTu) + plane_at_rest(u);
}

//{ looks
/* Output of the hysteresis after a monotone move to u$RATE_IN_WORDS; nothing is moved. */
static real hysteresis_look(const $name_state *state, real u$RATE_PARAMETER)
{
    return polynomial_at($TUNED_FIRSTu) + plane_look(state, u).output;
}

//}
/* Moves monotonically to u: *v is the output of the hysteresis there. 0, and nothing has moved, where that is
   out of range. */
static bool hysteresis_move($name_state *state, real u, real *v)
{
    const plane_move to = plane_look(state, u);
    const real out = polynomial_at($TUNED_FIRSTu) + to.output;
    if (!is_in_range(out)) {
        return false;
    }
    plane_make(state, to, u);
    state->voltage = u;
    *v = out;
    return true;
}

/* Makes the memory of the hysteresis virgin at u. */
static void hysteresis_rest($name_state *state, real u)
{
    state->virgin = u;
    state->plane_virgin = plane_at_rest(u);
    state->plane = state->plane_virgin;
    state->kept = 0;
    state->moved = false;
    state->rising = false;
}

//}
