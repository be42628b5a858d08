/* Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers. Exit code 0:
   passed. */
#include <stdio.h>

#include "$name.h"

typedef $name_real real;

#define SAMPLES $SAMPLES
/* The first references last a sample each, those from here on so many: what they do has come out of the
   preview and of slow states then. */
#define HELD_FROM $HELD_FROM
#define HOLD $HOLDL

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

static $name_state state;

static real difference(real a, real b)
{
    return a > b ? a - b : b - a;
}

static int passed(const char *what, int holds)
{
    printf("%s: %s\n", holds ? "passed" : "FAILED", what);
    return holds;
}

/* Whether a voltage keeps to the limits after the one before, but for the rounding of a difference. */
static int within_limits(real before, real voltage)
{
    const real rounding =
        R(4) * R(EPSILON) * ($NAME_VOLTAGE_HIGH - $NAME_VOLTAGE_LOW + difference($NAME_VOLTAGE_LOW, R(0)));
    return voltage >= $NAME_VOLTAGE_LOW && voltage <= $NAME_VOLTAGE_HIGH
        && difference(voltage, before) <= $NAME_VOLTAGE_STEP + rounding;
}

/* Along the golden references. */
static int golden(void)
{
    real worst = R(0), before, u = R(0), y;
    long run = 0;
    int k, good = 1;
    $name_init(&state);
    if ($name_rest_at(&state, rest, &y) != $NAME_OK) {
        return passed("rest", 0);
    }
    before = rest;
    for (k = 0; k < SAMPLES; k++) {
        long held = k < HELD_FROM ? 1L : HOLD;
        for (run += held; held > 0; held--) {
            good = good && $name_step(&state, references[k], &u) >= $NAME_OK && within_limits(before, u);
            before = u;
        }
        /* Written so that a NaN is a difference. */
        if (!(difference(u, voltages[k]) <= worst)) {
            worst = difference(u, voltages[k]);
        }
    }
    printf("golden vectors: %d of %ld samples, largest difference %.2e %s, allowed %.2e %s\n", SAMPLES, run,
           (double)worst, $INPUT_UNIT_STRING, (double)tolerance, $INPUT_UNIT_STRING);
    return passed("golden vectors", good && worst <= tolerance);
}

/* Whatever is handed in, every voltage keeps to the limits. */
static int bad_numbers(void)
{
    const real zero = references[0] - references[0];
    real bad[5], before, u = R(0), y;
    int k, good = 1;
    bad[0] = zero / zero;
    bad[1] = R(1) / zero;
    bad[2] = -bad[1];
    bad[3] = R(MAX);
    bad[4] = -R(MAX);
    $name_init(&state);
    good = good && $name_rest_at(&state, rest, &y) == $NAME_OK;
    before = rest;
    for (k = 0; k < SAMPLES; k++) {
        const int is_bad = k % 7 == 0;
        const $name_status status = $name_step(&state, is_bad ? bad[(k / 7) % 5] : references[k], &u);
        good = good && within_limits(before, u);
        good = good && (!is_bad || (k / 7) % 5 > 2 || status == $NAME_NOT_FINITE);
        good = good && $name_rest_at(&state, bad[k % 3], &y) == $NAME_NOT_FINITE;
        good = good && $name_measured_at_rest(&state, bad[k % 3]) == $NAME_NOT_FINITE;
        before = u;
    }
    return passed("whatever is handed in, every voltage keeps to the limits", good);
}

int main(void)
{
    const int all = golden() & bad_numbers();
    printf("%s: %s\n", all ? "PASSED" : "FAILED", "$name");
    return all ? 0 : 1;
}
