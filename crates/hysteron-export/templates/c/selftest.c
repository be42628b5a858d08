/* Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers. Exit code 0:
   passed. */
#include <stdio.h>

#include "$name.h"

typedef $name_real real;

#define SAMPLES $SAMPLES
/* The first voltages last a sample each, those from here on so many: what they do has come out of the delay
   and of slow states then. */
#define HELD_FROM $HELD_FROM
#define HOLD $HOLD

/* Voltages [$INPUT_UNIT], and the displacements [$OUTPUT_UNIT] at their ends that the library puts out in
   double precision. */
static const real voltages[SAMPLES] = {
$VOLTAGES
};
static const real displacements[SAMPLES] = {
$DISPLACEMENTS
};
/* Largest difference allowed [$OUTPUT_UNIT]: $TOLERANCE_IN_WORDS. */
static const real tolerance = $TOLERANCE;

static $name_state state, twin;

static real difference(real a, real b)
{
    return a > b ? a - b : b - a;
}

static bool passed(const char *what, bool holds)
{
    printf("%s: %s\n", holds ? "passed" : "FAILED", what);
    return holds;
}

/* Along the golden voltages. */
static bool golden(void)
{
    real worst = R(0), y;
    int32_t run = 0;
    $name_status status = $NAME_OK;
    int32_t k;
    $name_init(&state);
    if ($name_rest_at(&state, voltages[0], &y) < $NAME_OK) {
        return passed("rest", false);
    }
    for (k = 0; k < SAMPLES; k++) {
        int32_t held = k < HELD_FROM ? 1 : HOLD;
        for (run += held; held > 0; held--) {
            const $name_status now = $name_step(&state, voltages[k], &y);
            if (now < $NAME_OK) {
                status = now;
            }
        }
        /* Written so that a NaN is a difference. */
        if (!(difference(y, displacements[k]) <= worst)) {
            worst = difference(y, displacements[k]);
        }
    }
    printf("golden vectors: %d of %ld samples, largest difference %.2e %s, allowed %.2e %s\n", SAMPLES,
           (long)run, (double)worst, $OUTPUT_UNIT_STRING, (double)tolerance, $OUTPUT_UNIT_STRING);
    return passed("golden vectors", status == $NAME_OK && worst <= tolerance);
}

/* A start has no jump. */
static bool start(void)
{
    real y;
    $name_init(&state);
    if ($name_start_at(&state, voltages[SAMPLES / 3], R(17.25)) < $NAME_OK) {
        return passed("start", false);
    }
    if ($name_step(&state, voltages[SAMPLES / 3], &y) < $NAME_OK) {
        return passed("start", false);
    }
    return passed("a start has no jump", difference(y, R(17.25)) <= tolerance);
}

/* Bad numbers are refused, put out what was put out before, and leave no trace. */
static bool bad_numbers(void)
{
    const real zero = voltages[0] - voltages[0];
    real bad[3], y = R(0), held = R(0), other = R(0);
    bool same = true;
    int32_t k;
    bad[0] = zero / zero;
    bad[1] = R(1) / zero;
    bad[2] = -bad[1];
    $name_init(&state);
    $name_init(&twin);
    for (k = 0; k < SAMPLES; k++) {
        const $name_status status = $name_step(&state, voltages[k], &y);
        (void)$name_step(&twin, voltages[k], &other);
        same = same && status >= $NAME_OK && !(difference(y, other) > zero);
        if (k % 7 == 0) {
            const real u = bad[(k / 7) % 3];
            same = same && $name_step(&state, u, &held) == $NAME_NOT_FINITE && !(difference(held, y) > zero);
            same = same && $name_rest_at(&state, u, &held) == $NAME_NOT_FINITE
                && !(difference(held, y) > zero);
            same = same && $name_start_at(&state, voltages[k], u) == $NAME_NOT_FINITE;
//{ refuses_largest
            same = same && $name_step(&state, R(MAX), &held) == $NAME_OVERFLOW
                && !(difference(held, y) > zero);
//}
        }
    }
    return passed("bad numbers are refused, hold the output and leave no trace", same);
}

/* A state that is saved and restored half-way goes on with the same bits; damaged bytes are refused. */
static bool saved(void)
{
    static uint8_t bytes[$NAME_SAVED_BYTES];
    real y = R(0), other = R(0);
    bool same = true;
    int32_t k;
    uint32_t i;
    $name_init(&state);
    $name_init(&twin);
    for (k = 0; k < SAMPLES; k++) {
        same = same && $name_step(&state, voltages[k], &y) >= $NAME_OK;
        if (k >= SAMPLES / 2) {
            same = same && $name_step(&twin, voltages[k], &other) >= $NAME_OK && difference(y, other) <= R(0);
        }
        if (k == SAMPLES / 2 - 1) {
            $name_save(&state, bytes);
            for (i = 0u; i < $NAME_SAVED_BYTES; i += 1u + $NAME_SAVED_BYTES / 16u) {
                bytes[i] ^= 1u;
                same = same && $name_restore(&twin, bytes) == $NAME_NOT_SAVED;
                bytes[i] ^= 1u;
            }
            same = same && $name_restore(&twin, bytes) == $NAME_OK;
        }
    }
    return passed("a saved state goes on with the same bits, damaged bytes are refused", same);
}

/* Trims scale and shift what the model gives. */
static bool trims(void)
{
    $name_trims own, bad;
    real y = R(0), other = R(0);
    bool good = true;
    int32_t k;
    $name_init(&state);
    $name_init(&twin);
    own = state.trims;
    bad = own;
    own.gain = R(1.5);
    bad.gain = R(0);
    good = $name_trim(&twin, &bad) == $NAME_NOT_FINITE && $name_trim(&twin, &own) == $NAME_OK;
    for (k = 0; k < SAMPLES; k++) {
        good = good && $name_step(&state, voltages[k], &y) >= $NAME_OK;
        good = good && $name_step(&twin, voltages[k], &other) >= $NAME_OK;
        y = own.offset + R(1.5) * (y - own.offset);
        good = good && difference(y, other) <= R(2) * tolerance;
    }
    return passed("trims scale and shift the displacement", good);
}

int main(void)
{
    bool all = golden();
    all = start() && all;
    all = bad_numbers() && all;
    all = saved() && all;
    all = trims() && all;
    printf("%s: %s\n", all ? "PASSED" : "FAILED", "$name");
    return all ? 0 : 1;
}
