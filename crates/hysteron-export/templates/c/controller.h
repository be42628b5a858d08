$DESCRIPTION
#ifndef $NAME_H
#define $NAME_H

#include <stdbool.h>
#include <stdint.h>

#include "$inverse.h"
//{ law
#include "$law.h"
//}
//{ observer
#include "$observed.h"
//}

#ifdef __cplusplus
extern "C" {
#endif

typedef $inverse_real $name_real;

/* What a call has come to: as for the inverse, whose limits every voltage keeps to. */
typedef $inverse_status $name_status;
#define $NAME_OK $INVERSE_OK
#define $NAME_NOT_FINITE $INVERSE_NOT_FINITE
#define $NAME_OVERFLOW $INVERSE_OVERFLOW
#define $NAME_NOT_SAVED $INVERSE_NOT_SAVED

/* Samples a second [Hz]. The coefficients belong to this rate. */
#define $NAME_SAMPLE_RATE_HZ $INVERSE_SAMPLE_RATE_HZ

/* Trims, for the field: displacement = offset + gain * what the model gives. */
typedef $inverse_trims $name_trims;

/* Samples that the reference handed to a step is ahead of the one that this step's voltage ends at. */
#define $NAME_PREVIEW $INVERSE_PREVIEW

/* Everything the controller remembers. The caller's: static, on the stack, one for each device. Its members
   are read and changed by the functions below alone. */
typedef struct {
    $inverse_state inverse;
//{ law
    $law_state law;
//}
//{ feedback
    $name_real sum, carry;            /* of the errors */
    $name_real remembered, correction; /* of the parts with memory; of the reference */
    bool above, below;                /* the voltage was held back, and would have gone there */
//}
//{ observer
    $observed_state observed;
    $name_real disturbance; /* displacement of the stage less that of the model */
//}
    $name_real error;
    bool has_error;
    $name_real due[$NAME_PREVIEW + 1]; /* references from the present one on */
    uint32_t due_at; /* below $NAME_PREVIEW + 1: where they are written next */
} $name_state;

//+ size of a saved state
/* Makes a state of any memory: the stage at rest at the voltage within the limits that is next to 0. Call
   this once, first. */
void $name_init($name_state *state);

/* Puts everything at rest at `voltage` [$INPUT_UNIT], moved into the limits, where the stage was driven
   without turning from the voltage `virgin` and `measured` [$OUTPUT_UNIT] is read: the reference counts from
   the same zero. `displacement` is that of the model. */
$name_status $name_rest_after($name_state *state, $name_real virgin, $name_real voltage, $name_real measured,
                              $name_real *displacement);

/* Takes the newest of the reference without moving: what is known ahead when the first step is made, oldest
   first. */
$name_status $name_know($name_state *state, $name_real reference);

/* One period: the voltage [$INPUT_UNIT] for it. `reference` [$OUTPUT_UNIT] is the newest known,
   $NAME_PREVIEW samples ahead. */
$name_status $name_step($name_state *state, $name_real reference, $name_real *voltage);

/* After every step, when its voltage has gone out: the displacement [$OUTPUT_UNIT] read then. One that is
   infinite or not a number, where there is no reading, is left out. */
$name_status $name_measured($name_state *state, $name_real reading);

/* Changes the trims of the inverse and of what the readings are compared with, from the next step on.
   $NAME_NOT_FINITE for a number that is not finite, or a gain of 0: they are then as they were. */
$name_status $name_trim($name_state *state, const $name_trims *trims);

//+ functions of a saved state
#ifdef __cplusplus
}
#endif

#endif
