/* Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers. Exit code 0:
   passed. */
#include <stdio.h>

#include "$name.h"

typedef $name_real real;

#define VECTORS $VECTORS
/* Samples that a vector lasts: a quarter of them is longer than the preview. */
#define HOLD $HOLD
#define GIVEN $N_GIVEN
#define FOUND $N_FOUND

/* What goes in, and what the library puts out at the end of each. */
static const real given[VECTORS][GIVEN] = {
$GIVEN
};
static const real wanted[VECTORS][FOUND] = {
$WANTED
};
/* Largest difference allowed: $ALLOWED. */
static const real tolerance = $TOLERANCE;

static $name_state state, twin;

static real size(real x)
{
    return x < R(0) ? -x : x;
}

static bool golden(void)
{
    real found[FOUND], worst = R(0);
    int32_t i, k;
    $name_init(&state);
    for (k = 0; k < VECTORS; k++) {
        int32_t held;
        for (held = 0; held < HOLD; held++) {
            if ($name_step(&state, given[k], found) < $NAME_OK) {
                return false;
            }
        }
        for (i = 0; i < FOUND; i++) {
            /* Written so that a NaN is a difference. */
            if (!(size(found[i] - wanted[k][i]) <= worst)) {
                worst = size(found[i] - wanted[k][i]);
            }
        }
    }
    printf("golden vectors: %d of %ld samples, largest difference %.2e, allowed %.2e\n", VECTORS,
           (long)VECTORS * HOLD, (double)worst, (double)tolerance);
    return worst <= tolerance;
}

static bool bad_numbers(void)
{
    const real zero = given[0][0] - given[0][0];
    real found[FOUND], bad[GIVEN];
    bool good = true;
    int32_t i, k;
    $name_init(&state);
    for (k = 0; k < VECTORS; k++) {
        const bool is_bad = k % 7 == 3;
        $name_status status;
        for (i = 0; i < GIVEN; i++) {
            bad[i] = is_bad ? (k % 2 == 0 ? zero / zero : R(1) / zero) : given[k][i];
        }
        status = $name_step(&state, bad, found);
        good = good && (status == $NAME_NOT_FINITE) == is_bad;
        for (i = 0; i < FOUND; i++) {
            good = good && found[i] - found[i] == R(0);
        }
    }
    return good;
}

static bool saved(void)
{
    static uint8_t bytes[$NAME_SAVED_BYTES];
    real found[FOUND], other[FOUND];
    bool same = true;
    int32_t i, k;
    $name_init(&state);
    for (k = 0; k < VECTORS; k++) {
        same = same && $name_step(&state, given[k], found) >= $NAME_OK;
        if (k >= VECTORS / 2) {
            same = same && $name_step(&twin, given[k], other) >= $NAME_OK;
            for (i = 0; i < FOUND; i++) {
                same = same && size(found[i] - other[i]) <= R(0);
            }
        }
        if (k == VECTORS / 2 - 1) {
            $name_save(&state, bytes);
            bytes[$NAME_SAVED_BYTES / 2] ^= 1u;
            same = same && $name_restore(&twin, bytes) == $NAME_NOT_SAVED;
            bytes[$NAME_SAVED_BYTES / 2] ^= 1u;
            same = same && $name_restore(&twin, bytes) == $NAME_OK;
        }
    }
    return same;
}

int main(void)
{
    const bool numbers = golden(), whatever = bad_numbers(), goes_on = saved();
    const bool all = numbers && whatever && goes_on;
    printf("%s: golden vectors\n%s: bad numbers are not used\n", numbers ? "passed" : "FAILED",
           whatever ? "passed" : "FAILED");
    printf("%s: a saved state goes on with the same bits\n", goes_on ? "passed" : "FAILED");
    printf("%s: %s\n", all ? "PASSED" : "FAILED", "$name");
    return all ? 0 : 1;
}
