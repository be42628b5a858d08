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

/* What a call has come to. 0 and above: there is a result. Below 0: the state is what it was, and the result
   handed back is that of the last call that had one. */
typedef enum {
    $NAME_OK = 0,
//{ range
    /* There is a result, but the voltage lies outside of the range that the model was identified in
       ($NAME_VOLTAGE_LOW to $NAME_VOLTAGE_HIGH and a hundredth of it to either side): the model
       extrapolates. */
    $NAME_EXTRAPOLATED = 1,
//}
    /* A voltage, displacement or trim is infinite or not a number, or a gain 0. */
    $NAME_NOT_FINITE = -1,
    /* The hysteresis leaves the range that can be computed with (above 1e$LARGEST_EXPONENT): a voltage out of
       all reason. */
    $NAME_OVERFLOW = -2,
    /* The bytes are no saved state of this export, or damaged: the state is what it was. */
    $NAME_NOT_SAVED = -3
} $name_status;

/* Samples a second [Hz]. The coefficients belong to this rate. */
#define $NAME_SAMPLE_RATE_HZ $RATE
//{ range
/* Range of the voltage that the model was identified in [$INPUT_UNIT]. */
#define $NAME_VOLTAGE_LOW $RANGE_LOW
#define $NAME_VOLTAGE_HIGH $RANGE_HIGH
//}
/* Numbers in the tables of the model. */
//+ sizes
#define $NAME_TAPS $N_TAPS
//{ real_poles
#define $NAME_REAL_POLES $N_REAL
//}
//{ pairs
#define $NAME_PAIRS $N_PAIRS
//}
/* Whole samples of delay. */
#define $NAME_DELAY $N_DELAY
