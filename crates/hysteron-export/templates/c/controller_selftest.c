/* Self-test of $name: the voltages of hysteron's own simulation for its references and readings, and what
   happens with bad numbers. Exit code 0: passed. */
#include <stdio.h>

#include "$name.h"

typedef $name_real real;

#define SAMPLES $SAMPLES

/* Voltage to rest at first [$INPUT_UNIT], and what is read there [$OUTPUT_UNIT]. */
static const real rest = $REST;
static const real measured = $MEASURED;
/* References [$OUTPUT_UNIT]; the voltages [$INPUT_UNIT] of the library, and what was read of a simulated
   stage when they had gone out. */
static const real references[SAMPLES] = {
$REFERENCES
};
static const real voltages[SAMPLES] = {
$VOLTAGES
};
static const real readings[SAMPLES] = {
$READINGS
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

static real ahead(int32_t k)
{
    return references[k < SAMPLES ? k : SAMPLES - 1];
}

static bool begin($name_state *one)
{
    real y;
    int32_t k;
    $name_init(one);
    if ($name_rest_after(one, rest, rest, measured, &y) != $NAME_OK) {
        return false;
    }
    for (k = 0; k < $NAME_PREVIEW; k++) {
        (void)$name_know(one, ahead(k));
    }
    return true;
}

/* Along the references and readings; half-way saved, restored and compared bit by bit. */
static bool golden(void)
{
    static uint8_t bytes[$NAME_SAVED_BYTES];
    real worst = R(0), u = R(0), other = R(0);
    bool good = begin(&state), same = true;
    int32_t k;
    $name_init(&twin);
    for (k = 0; k < SAMPLES; k++) {
        good = good && $name_step(&state, ahead(k + $NAME_PREVIEW), &u) >= $NAME_OK;
        good = good && $name_measured(&state, readings[k]) == $NAME_OK;
        /* Written so that a NaN is a difference. */
        if (!(difference(u, voltages[k]) <= worst)) {
            worst = difference(u, voltages[k]);
        }
        if (k > SAMPLES / 2) {
            same = same && $name_step(&twin, ahead(k + $NAME_PREVIEW), &other) >= $NAME_OK;
            same = same && $name_measured(&twin, readings[k]) == $NAME_OK && difference(u, other) <= R(0);
        }
        if (k == SAMPLES / 2) {
            $name_save(&state, bytes);
            bytes[$NAME_SAVED_BYTES / 2] ^= 1u;
            same = same && $name_restore(&twin, bytes) == $NAME_NOT_SAVED;
            bytes[$NAME_SAVED_BYTES / 2] ^= 1u;
            same = same && $name_restore(&twin, bytes) == $NAME_OK;
        }
    }
    printf("%d samples, largest difference %.2e %s, allowed %.2e %s\n", SAMPLES, (double)worst,
           $INPUT_UNIT_STRING, (double)tolerance, $INPUT_UNIT_STRING);
    same = passed("a saved state goes on with the same bits, damaged bytes are refused", same);
    return passed("golden vectors", good && worst <= tolerance) && same;
}

/* Whatever is handed in, every voltage keeps to the limits. */
static bool bad_numbers(void)
{
    const real zero = references[0] - references[0];
    real bad[5], u = R(0);
    bool good = begin(&state);
    int32_t k;
    bad[0] = zero / zero;
    bad[1] = R(1) / zero;
    bad[2] = -bad[1];
    bad[3] = R(MAX);
    bad[4] = -R(MAX);
    for (k = 0; k < SAMPLES; k++) {
        (void)$name_step(&state, k % 7 == 0 ? bad[(k / 7) % 5] : references[k], &u);
        good = good && u >= $INVERSE_VOLTAGE_LOW && u <= $INVERSE_VOLTAGE_HIGH;
        (void)$name_measured(&state, k % 11 == 0 ? bad[(k / 11) % 5] : readings[k]);
    }
    return passed("whatever is handed in, every voltage keeps to the limits", good);
}

/* On a stage that moves twice as far, trimmed to it: the same voltages for twice the reference. */
static bool trims(void)
{
    $name_trims own, none;
    real u = R(0), other = R(0), y = R(0);
    bool good = begin(&state);
    int32_t k;
    own = state.inverse.trims;
    own.gain = R(2);
    none = own;
    none.gain = R(0);
    $name_init(&twin);
    good = good && $name_trim(&twin, &none) == $NAME_NOT_FINITE && $name_trim(&twin, &own) == $NAME_OK;
    y = own.offset + R(2) * (measured - own.offset);
    good = good && $name_rest_after(&twin, rest, rest, y, &other) == $NAME_OK;
    for (k = 0; k < $NAME_PREVIEW; k++) {
        (void)$name_know(&twin, own.offset + R(2) * (ahead(k) - own.offset));
    }
    for (k = 0; k < SAMPLES; k++) {
        const real twice = own.offset + R(2) * (ahead(k + $NAME_PREVIEW) - own.offset);
        good = good && $name_step(&state, ahead(k + $NAME_PREVIEW), &u) >= $NAME_OK;
        good = good && $name_step(&twin, twice, &other) >= $NAME_OK;
        good = good && difference(u, other) <= R(2) * tolerance;
        (void)$name_measured(&state, readings[k]);
        (void)$name_measured(&twin, own.offset + R(2) * (readings[k] - own.offset));
    }
    return passed("trims scale what is followed and read", good);
}

int main(void)
{
    bool all = golden();
    all = bad_numbers() && all;
    all = trims() && all;
    printf("%s: %s\n", all ? "PASSED" : "FAILED", "$name");
    return all ? 0 : 1;
}
