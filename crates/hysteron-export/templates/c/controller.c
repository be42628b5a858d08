$DESCRIPTION
#include <string.h>

#include "$name.h"

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: the sum of small errors is compensated, which it takes away"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

typedef $name_real real;

//{ feedback
/* Gains on the error, and on the sum of errors. */
static const real PROPORTIONAL = $PROPORTIONAL;
static const real INTEGRAL = $INTEGRAL;
//}
//{ observer
/* Share of the difference to the reading that the disturbance moves by. */
static const real OBSERVER_GAIN = $OBSERVER_GAIN;
//}

static bool is_finite(real x)
{
    return x - x == R(0);
}

/* The newest reference, as the inverse has taken it. */
static void take_reference($name_state *state)
{
    state->due[state->due_at] = state->inverse.reference;
    state->due_at = (state->due_at + 1u) % ((uint32_t)$NAME_PREVIEW + 1u);
}

//{ feedback
/* The correction by the newest error: proportional, integral$LAW_IN_WORDS. While the voltage is held back
   what would drive it on is not summed up. */
static void correct($name_state *state)
{
    const real error = state->error;
    if (!state->has_error || error > R(LARGEST) || error < -R(LARGEST)) {
        return;
    }
    if (!((state->above && error > R(0)) || (state->below && error < R(0))
          || (state->above && state->below))) {
        /* Without losing what is smaller than half a unit of the sum (W. Kahan 1965,
           doi:10.1145/363707.363723). */
        const real more = INTEGRAL * error + state->carry;
        const real sum = state->sum + more;
//{ law
        real remembered = R(0);
//}
        state->carry = more - (sum - state->sum);
        state->sum = sum;
//{ law
        (void)$law_step(&state->law, error, &remembered);
        state->remembered = state->sum + remembered;
//}
//{ !law
        state->remembered = state->sum;
//}
    }
    state->correction = PROPORTIONAL * error + state->remembered;
}

//}
static void rest($name_state *state, real displacement)
{
    int32_t k;
//{ law
    $law_init(&state->law);
//}
//{ feedback
    state->sum = R(0);
    state->carry = R(0);
    state->remembered = R(0);
    state->correction = R(0);
    state->above = false;
    state->below = false;
//}
    state->error = R(0);
    state->has_error = true;
    state->due_at = 0u;
    for (k = 0; k <= $NAME_PREVIEW; k++) {
        state->due[k] = displacement;
    }
}

void $name_init($name_state *state)
{
    $inverse_init(&state->inverse);
//{ observer
    $observed_init(&state->observed);
    state->disturbance = R(0);
//}
    rest(state, state->inverse.displacement);
}

$name_status $name_rest_after($name_state *state, real virgin, real voltage, real measured,
                              real *displacement)
{
    $name_status status;
//{ observer
    real own;
//}
    *displacement = state->inverse.displacement;
    if (!is_finite(measured)) {
        return $NAME_NOT_FINITE;
    }
    status = $inverse_rest_after(&state->inverse, virgin, voltage, displacement);
    if (status < $NAME_OK) {
        return status;
    }
//{ observer
    if ($observed_rest_after(&state->observed, virgin, state->inverse.voltage, &own) < $OBSERVED_OK) {
        return $NAME_OVERFLOW;
    }
    state->disturbance = measured - own;
//}
    rest(state, *displacement);
    return status;
}

$name_status $name_know($name_state *state, real reference)
{
    const $name_status status = $inverse_know(&state->inverse, reference);
    take_reference(state);
    return status;
}

$name_status $name_step($name_state *state, real reference, real *voltage)
{
//{ feedback
    const real before = state->inverse.voltage;
//}
    $name_status status;
    real against = R(0);
//{ observer
    against = state->disturbance;
//}
//{ feedback
    correct(state);
    against = against - state->correction;
//}
    status = $inverse_step_against(&state->inverse, reference, against, voltage);
    take_reference(state);
//{ feedback
    {
        const bool held = status == $INVERSE_AT_RANGE || status == $INVERSE_AT_SLEW;
        const bool up = *voltage > before || *voltage >= $INVERSE_VOLTAGE_HIGH;
        state->above = (held && up) || status == $NAME_OVERFLOW;
        state->below = (held && !up) || status == $NAME_OVERFLOW;
    }
//}
    return status;
}

$name_status $name_measured($name_state *state, real reading)
{
//{ observer
    real own;
//}
    state->error = state->due[state->due_at] - reading;
    state->has_error = is_finite(state->error);
//{ observer
    if ($observed_step(&state->observed, state->inverse.voltage, &own) >= $OBSERVED_OK) {
        const real left = reading - own - state->disturbance;
        if (is_finite(left)) {
            state->disturbance = state->disturbance + OBSERVER_GAIN * left;
        }
    }
//}
    if (!state->has_error) {
        state->error = R(0);
        return $NAME_NOT_FINITE;
    }
    return $NAME_OK;
}

$name_status $name_trim($name_state *state, const $name_trims *trims)
{
//{ observer
    $observed_trims own;
    own.gain = trims->gain;
    own.offset = trims->offset;
    if ($observed_trim(&state->observed, &own) < $OBSERVED_OK) {
        return $NAME_NOT_FINITE;
    }
//}
    return $inverse_trim(&state->inverse, trims);
}
