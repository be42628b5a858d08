$DESCRIPTION
#ifndef $NAME_H
#define $NAME_H

//{ no_slew
#include <math.h>
//}
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The number type of everything in here. */
typedef $real $name_real;

/* What a call has come to. The voltage handed back lies within the limits below whatever the status says. */
typedef enum {
    /* The model follows. */
    $NAME_OK = 0,
    /* The range of voltages holds the drive back. */
    $NAME_AT_RANGE = 1,
    /* The largest change from one sample to the next holds the drive back. */
    $NAME_AT_SLEW = 2,
    /* A number handed in is infinite or not a number, or a reference so large that no voltage follows. In a
       step the last reference that was finite is followed on; the other calls leave the state as it was. */
    $NAME_NOT_FINITE = -1,
    /* The hysteresis leaves the range that can be computed with: the voltage stays as it was. */
    $NAME_OVERFLOW = -2,
    /* The bytes are no saved state of this export, or damaged: the state is what it was. */
    $NAME_NOT_SAVED = -3
} $name_status;

/* Samples a second [Hz]. The coefficients belong to this rate. */
#define $NAME_SAMPLE_RATE_HZ $RATE
/* Samples that the reference handed to a step is ahead of the one that this step's voltage ends at. */
#define $NAME_PREVIEW $N_PREVIEW
/* Limits of the voltage [$INPUT_UNIT], and of its change from one sample to the next [$INPUT_UNIT]. */
#define $NAME_VOLTAGE_LOW $LIMIT_LOW
#define $NAME_VOLTAGE_HIGH $LIMIT_HIGH
#define $NAME_VOLTAGE_STEP $LIMIT_STEP
/* Numbers in the tables of the compensator. */
//+ sizes
#define $NAME_TAPS $N_TAPS
//{ real_poles
#define $NAME_REAL_POLES $N_REAL
//}
//{ pairs
#define $NAME_PAIRS $N_PAIRS
//}
#define $NAME_REFERENCES $N_REFERENCES

