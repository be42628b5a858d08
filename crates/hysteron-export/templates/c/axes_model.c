$DESCRIPTION
#include <string.h>

#include "$name.h"

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

typedef $name_real real;

#define INPUTS $NAME_INPUTS
#define OUTPUTS $NAME_OUTPUTS
#define MODES $NAME_MODES
#define STATES $NAME_STATES
/* Steps of the model in one sample, and those after which every state has settled. */
#define STEPS $N_STEPS
#define SETTLES $N_SETTLES
//{ plays
#define PLAYS $NAME_PLAYS
//}

$TABLES
static bool is_finite(real x)
{
    return x - x == R(0);
}

static real dot(const real *a, const real *b, int32_t count)
{
    real sum = R(0);
    int32_t k;
    for (k = 0; k < count; k++) {
        sum += a[k] * b[k];
    }
    return sum;
}

//{ strains
/* The strains of the actuators under their voltages; moves the plays. */
static void strains($name_state *state, const real *u)
{
    int32_t i;
//{ plays
    int32_t j;
//}
    for (i = 0; i < INPUTS; i++) {
        state->strain[i] = R(0);
    }
    for (i = 0; i < 2 * INPUTS; i++) {
        const real all = dot(ROWS[i], state->x, STATES) + dot(ROWS[i] + STATES, u, INPUTS);
        const real z = all > REACH[i] ? REACH[i] : all < -REACH[i] ? -REACH[i] : all;
        const real square = z * z - VARIANCE[i];
        const real cube = z * z * z - R(3) * VARIANCE[i] * z;
        real value = POWERS[i][0] * square + POWERS[i][1] * cube;
//{ plays
        for (j = 0; j < PLAYS; j++) {
            real *play = &state->plays[i][j];
            if (z - RADII[i][j] > *play) {
                *play = z - RADII[i][j];
            } else if (z + RADII[i][j] < *play) {
                *play = z + RADII[i][j];
            }
            value += WEIGHTS[i][j] * (*play - SLOPES[i][j] * z);
        }
//}
        state->strain[i % INPUTS] += value;
    }
}

//}
/* One step of the modes and lags under the voltages held. */
static void advance($name_state *state)
{
    real next[STATES];
    int32_t k;
    for (k = 0; k < STATES; k++) {
        next[k] = dot(INPUT[k], state->held, INPUTS) + dot(STRAIN_INPUT[k], state->strain, INPUTS);
    }
    for (k = 0; k < MODES; k++) {
        const real a = TRANSITION[2 * k], b = TRANSITION[2 * k + 1];
        const real re = state->x[2 * k], im = state->x[2 * k + 1];
        next[2 * k] = a * re - b * im + next[2 * k];
        next[2 * k + 1] = a * im + b * re + next[2 * k + 1];
    }
    for (k = 2 * MODES; k < STATES; k++) {
        next[k] = TRANSITION[k] * state->x[k] + next[k];
    }
    for (k = 0; k < STATES; k++) {
        state->x[k] = next[k];
    }
}

/* To the next sample. */
static void next_sample($name_state *state)
{
    int32_t step;
    for (step = 0; step < STEPS; step++) {
//{ strains
        if (step > 0) {
            strains(state, state->held);
        }
//}
        advance(state);
    }
}

/* The outputs under voltages; true if they are numbers. */
static bool find_output($name_state *state, const real *u)
{
    bool all = true;
    int32_t m;
//{ strains
    strains(state, u);
//}
    for (m = 0; m < OUTPUTS; m++) {
        state->output[m] = dot(OUTPUT[m], state->x, STATES) + dot(FEEDTHROUGH[m], u, INPUTS)
            + dot(STRAIN_FEEDTHROUGH[m], state->strain, INPUTS);
        all = all && is_finite(state->output[m]);
    }
    return all;
}

/* Holds voltages from the present sample on; the outputs at it. False where the motion has left the range of
   numbers: it goes on from 0 then, without memory. */
static bool apply($name_state *state, const real *u)
{
    int32_t i, k;
//{ plays
    int32_t j;
//}
    for (i = 0; i < INPUTS; i++) {
        state->held[i] = u[i];
    }
    if (find_output(state, u)) {
        return true;
    }
    for (k = 0; k < STATES; k++) {
        state->x[k] = R(0);
    }
//{ plays
    for (i = 0; i < 2 * INPUTS; i++) {
        for (j = 0; j < PLAYS; j++) {
            state->plays[i][j] = R(0);
        }
    }
//}
    (void)find_output(state, u);
    return false;
}

static void settle($name_state *state, const real *u)
{
    static const $name_state still;
    int32_t i;
    int32_t k;
    *state = still;
    for (i = 0; i < INPUTS; i++) {
        state->held[i] = u[i];
    }
    for (k = 0; k < SETTLES; k++) {
//{ strains
        strains(state, u);
//}
        advance(state);
    }
    (void)apply(state, u);
}
