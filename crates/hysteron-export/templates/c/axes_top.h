$DESCRIPTION
#ifndef $NAME_H
#define $NAME_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The number type of everything in here. */
typedef $real $name_real;

/* What a call has come to. */
typedef enum {
    $NAME_OK = 0,
//{ range
    /* There is a result, but a voltage lies outside of the range that the model was identified in
       ($NAME_VOLTAGE_LOW to $NAME_VOLTAGE_HIGH and a hundredth of it to either side): the model
       extrapolates. */
    $NAME_EXTRAPOLATED = 1,
//}
//{ inverse
    /* A voltage was held back by its range. */
    $NAME_AT_RANGE = 1,
    /* A voltage was held back by its largest change from one sample to the next. */
    $NAME_AT_SLEW = 2,
//}
    /* A number handed in is infinite or not a number: the last finite one is used in its place. */
    $NAME_NOT_FINITE = -1,
    /* The motion of the model has left the range of numbers, under a drive far from those it was identified with:
       it goes on from 0, without memory. Voltages stay within their limits. */
    $NAME_OVERFLOW = -2,
    /* The bytes are no saved state of this export, or damaged: the state is what it was. */
    $NAME_NOT_SAVED = -3
} $name_status;

/* Samples a second [Hz]. The coefficients belong to this rate. */
#define $NAME_SAMPLE_RATE_HZ $RATE
/* Actuators, axes, states. */
#define $NAME_INPUTS $N_INPUTS
#define $NAME_OUTPUTS $N_OUTPUTS
#define $NAME_MODES $N_MODES
#define $NAME_STATES (2 * $N_MODES + $N_INPUTS)
//{ range
/* Range of the voltages that the model was identified in [$INPUT_UNIT]. */
#define $NAME_VOLTAGE_LOW $RANGE_LOW
#define $NAME_VOLTAGE_HIGH $RANGE_HIGH
//}
//{ inverse
/* Limits of the voltages [$INPUT_UNIT], and their largest changes from one sample to the next, as initialisers
   of an array of $NAME_INPUTS. */
#define $NAME_VOLTAGES_LOW $LIMITS_LOW
#define $NAME_VOLTAGES_HIGH $LIMITS_HIGH
#define $NAME_VOLTAGES_STEP $LIMITS_STEP
//}
//{ plays
#define $NAME_PLAYS $N_PLAYS
//}
//{ inverse
/* Samples that the references handed to a step are ahead of those that its voltages are for. */
#define $NAME_PREVIEW $N_PREVIEW
//}

/* Everything that it remembers; read and changed by the functions below alone. */
typedef struct {
    $name_real x[$NAME_STATES];
    $name_real held[$NAME_INPUTS];
    $name_real strain[$NAME_INPUTS];
//{ plays
    $name_real plays[2 * $NAME_INPUTS][$NAME_PLAYS];
//}
    $name_real output[$NAME_OUTPUTS];
//{ inverse
    $name_real before[$NAME_INPUTS];
    $name_real last_strain[$NAME_INPUTS];
    $name_real predicted[$NAME_INPUTS];
    $name_real rate[$NAME_INPUTS];
    $name_real window[$NAME_PREVIEW + 1][$NAME_OUTPUTS];
    int32_t present; /* below $NAME_PREVIEW + 1: where the window is written next */
//}
} $name_state;

//+ size of a saved state
//{ !inverse
/* At rest under voltages of 0. Call this once, first. */
void $name_init($name_state *state);

/* At rest under these voltages [$INPUT_UNIT]: simulates until every state has settled. Not for real time. */
$name_status $name_rest_at($name_state *state, const $name_real voltages[$NAME_INPUTS]);

/* One sample: these voltages [$INPUT_UNIT] are held from now on; `outputs` [$OUTPUT_UNIT] are those now. */
$name_status $name_step($name_state *state, const $name_real voltages[$NAME_INPUTS],
                        $name_real outputs[$NAME_OUTPUTS]);
//}
//{ inverse
/* At rest under the voltages within the limits that are nearest to 0. Call this once, first. */
void $name_init($name_state *state);

/* At rest under these voltages [$INPUT_UNIT], moved into the limits: simulates until every state has settled.
   The references known are the outputs there, which `outputs` [$OUTPUT_UNIT] takes. Not for real time. */
$name_status $name_rest_at($name_state *state, const $name_real voltages[$NAME_INPUTS],
                           $name_real outputs[$NAME_OUTPUTS]);

/* Takes the newest references without moving: called $NAME_PREVIEW times before the first step, oldest
   first. */
$name_status $name_know($name_state *state, const $name_real references[$NAME_OUTPUTS]);

/* One sample: the voltages [$INPUT_UNIT] to be held from now on. `references` [$OUTPUT_UNIT] are the newest
   known, $NAME_PREVIEW samples ahead. The voltages keep to their limits whatever the status says. */
$name_status $name_step($name_state *state, const $name_real references[$NAME_OUTPUTS],
                        $name_real voltages[$NAME_INPUTS]);
//}

//+ functions of a saved state
#ifdef __cplusplus
}
#endif

#endif
