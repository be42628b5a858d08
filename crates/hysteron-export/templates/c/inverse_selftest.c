/* Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers. Exit code 0:
   passed. */
#include <stdio.h>

#include "$name.h"

typedef $name_real real;

#define SAMPLES $SAMPLES
/* The first references last a sample each, those from here on so many: what they do has come out of the
   preview and of slow states then. */
#define HELD_FROM $HELD_FROM
#define HOLD $HOLD

/* Voltage to rest at first [$INPUT_UNIT]. */
static const real rest = $REST;
/* References [$OUTPUT_UNIT], and the voltages [$INPUT_UNIT] at their ends that the library puts out in double
   precision. */
static const real references[SAMPLES] = {
$REFERENCES
};
static const real voltages[SAMPLES] = {
$VOLTAGES
};
/* Largest difference allowed [$INPUT_UNIT]: $TOLERANCE_IN_WORDS. */
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

/* Whether a voltage keeps to the limits after the one before, but for the rounding of a difference. */
static bool within_limits(real before, real voltage)
{
    const real rounding =
        R(4) * R(EPSILON) * ($NAME_VOLTAGE_HIGH - $NAME_VOLTAGE_LOW + difference($NAME_VOLTAGE_LOW, R(0)));
    return voltage >= $NAME_VOLTAGE_LOW && voltage <= $NAME_VOLTAGE_HIGH
        && difference(voltage, before) <= $NAME_VOLTAGE_STEP + rounding;
}

/* Along the golden references. */
static bool golden(void)
{
    real worst = R(0), before, u = R(0), y;
    int32_t run = 0;
    bool good = true;
    int32_t k;
    $name_init(&state);
    if ($name_rest_at(&state, rest, &y) != $NAME_OK) {
        return passed("rest", false);
    }
    before = rest;
    for (k = 0; k < SAMPLES; k++) {
        int32_t held = k < HELD_FROM ? 1 : HOLD;
        for (run += held; held > 0; held--) {
            good = good && $name_step(&state, references[k], &u) >= $NAME_OK && within_limits(before, u);
            before = u;
        }
        /* Written so that a NaN is a difference. */
        if (!(difference(u, voltages[k]) <= worst)) {
            worst = difference(u, voltages[k]);
        }
    }
    printf("golden vectors: %d of %ld samples, largest difference %.2e %s, allowed %.2e %s\n", SAMPLES,
           (long)run, (double)worst, $INPUT_UNIT_STRING, (double)tolerance, $INPUT_UNIT_STRING);
    return passed("golden vectors", good && worst <= tolerance);
}

/* Whatever is handed in, every voltage keeps to the limits. */
static bool bad_numbers(void)
{
    const real zero = references[0] - references[0];
    real bad[5], before, u = R(0), y;
    bool good = true;
    int32_t k;
    bad[0] = zero / zero;
    bad[1] = R(1) / zero;
    bad[2] = -bad[1];
    bad[3] = R(MAX);
    bad[4] = -R(MAX);
    $name_init(&state);
    good = good && $name_rest_at(&state, rest, &y) == $NAME_OK;
    before = rest;
    for (k = 0; k < SAMPLES; k++) {
        const bool is_bad = k % 7 == 0;
        const $name_status status = $name_step(&state, is_bad ? bad[(k / 7) % 5] : references[k], &u);
        good = good && within_limits(before, u);
        good = good && (!is_bad || (k / 7) % 5 > 2 || status == $NAME_NOT_FINITE);
        good = good && $name_rest_at(&state, bad[k % 3], &y) == $NAME_NOT_FINITE;
        good = good && $name_measured_at_rest(&state, bad[k % 3]) == $NAME_NOT_FINITE;
        before = u;
    }
    return passed("whatever is handed in, every voltage keeps to the limits", good);
}

/* A state that is saved and restored half-way goes on with the same bits; damaged bytes are refused. */
static bool saved(void)
{
    static uint8_t bytes[$NAME_SAVED_BYTES];
    real u = R(0), other = R(0);
    bool same = true;
    int32_t k;
    uint32_t i;
    $name_init(&state);
    $name_init(&twin);
    for (k = 0; k < SAMPLES; k++) {
        same = same && $name_step(&state, references[k], &u) >= $NAME_OK;
        if (k >= SAMPLES / 2) {
            same = same && $name_step(&twin, references[k], &other) >= $NAME_OK;
            same = same && difference(u, other) <= R(0);
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
    real u = R(0), other = R(0), y = R(0);
    bool good = true;
    int32_t k;
    $name_init(&state);
    $name_init(&twin);
    own = state.trims;
    bad = own;
    own.gain = R(2);
    bad.gain = R(0);
    good = $name_trim(&twin, &bad) == $NAME_NOT_FINITE && $name_trim(&twin, &own) == $NAME_OK;
    good = good && $name_rest_at(&state, rest, &y) == $NAME_OK;
    good = good && $name_rest_at(&twin, rest, &other) == $NAME_OK;
    for (k = 0; k < HELD_FROM; k++) {
        const real twice = own.offset + R(2) * (references[k] - own.offset);
        good = good && $name_step(&state, references[k], &u) >= $NAME_OK;
        good = good && $name_step(&twin, twice, &other) >= $NAME_OK;
        good = good && difference(u, other) <= R(2) * tolerance;
    }
    return passed("trims scale and shift the reference", good);
}

int main(void)
{
    bool all = golden();
    all = bad_numbers() && all;
    all = saved() && all;
    all = trims() && all;
    printf("%s: %s\n", all ? "PASSED" : "FAILED", "$name");
    return all ? 0 : 1;
}
