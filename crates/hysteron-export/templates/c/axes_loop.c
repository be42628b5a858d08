/* A control loop around $name: references in, voltages out, once a sample. Written by hysteron export; replace
 * the six functions below by those of your hardware.
 *
 * Timing of a period T = 1/$NAME_SAMPLE_RATE_HZ s, the sample timer ticking at its beginning:
 *   1. The voltages computed in the period before go to the converters at once, and are held for T: it is these
 *      held voltages that the law was made for.
 *   2. The next references are taken ($NAME_PREVIEW samples ahead) and the next voltages computed. This may take
 *      any time below T.
 * Voltages put out at a tick were computed one tick earlier: count this one period, and the time converters and
 * amplifiers take, as delay (a model identified from drives and responses as the controller sees them has it
 * already).
 *
 * Start, also after a power cycle with the stage anywhere; no voltage moves further in a sample than it may:
 *   - where it is known what the converters put out (read back, or remembered over the reset), the stage is taken
 *     over there, at rest;
 *   - where it is not, the voltages go from the best guess to those next to 0 within the limits, and wait SETTLES
 *     samples there. The error of the guess causes one step.
 * Then the displacements are measured, and the references count from them. What the hysteresis remembers from
 * before is not known. After this the loop is feedforward. */
#include "$name.h"

/* $SETTLES_IN_WORDS */
#define SETTLES $SETTLESUL

extern void wait_for_tick(void);                                      /* returns at the beginning of a period */
extern void next_references($name_real references[$NAME_OUTPUTS]);    /* [$OUTPUT_UNIT] */
extern void read_displacements($name_real outputs[$NAME_OUTPUTS]);    /* converters to digital [$OUTPUT_UNIT] */
extern bool present_voltages($name_real voltages[$NAME_INPUTS]);      /* what the converters put out now
                                                                         [$INPUT_UNIT]: true where it is known,
                                                                         false where it is a guess */
extern void write_voltages(const $name_real voltages[$NAME_INPUTS]);  /* converters to analogue [$INPUT_UNIT] */
extern void alarm($name_status status);

void control_loop(uint32_t samples);

static const $name_real LOW[$NAME_INPUTS] = $NAME_VOLTAGES_LOW;
static const $name_real HIGH[$NAME_INPUTS] = $NAME_VOLTAGES_HIGH;
static const $name_real STEP[$NAME_INPUTS] = $NAME_VOLTAGES_STEP;

static $name_real within($name_real x, $name_real low, $name_real high)
{
    return x < low ? low : x > high ? high : x;
}

/* The voltages to start from; false where one is not a number. */
static bool take_over($name_real voltages[$NAME_INPUTS])
{
    const bool known = present_voltages(voltages);
    bool waits = !known, moves = true;
    uint32_t waited;
    int32_t i;
    for (i = 0; i < $NAME_INPUTS; i++) {
        if (!(voltages[i] - voltages[i] <= R(0))) {
            return false;
        }
    }
    while (moves) {
        moves = false;
        for (i = 0; i < $NAME_INPUTS; i++) {
            const $name_real there = within(known ? voltages[i] : R(0), LOW[i], HIGH[i]);
            if (voltages[i] < there || voltages[i] > there) {
                voltages[i] = within(there, voltages[i] - STEP[i], voltages[i] + STEP[i]);
                moves = true;
            }
        }
        if (moves) {
            waits = true;
            wait_for_tick();
            write_voltages(voltages);
        }
    }
    for (waited = 0; waits && waited < SETTLES; waited++) {
        wait_for_tick();
    }
    return true;
}

/* References about the displacements measured: `apart` is how far those of the model are from them. */
static void take_references($name_real references[$NAME_OUTPUTS], const $name_real apart[$NAME_OUTPUTS])
{
    int32_t m;
    next_references(references);
    for (m = 0; m < $NAME_OUTPUTS; m++) {
        references[m] += apart[m];
    }
}

void control_loop(uint32_t samples)
{
    static $name_state state;
    $name_real voltages[$NAME_INPUTS], references[$NAME_OUTPUTS], apart[$NAME_OUTPUTS], measured[$NAME_OUTPUTS];
    int32_t ahead, m;
    if (!take_over(voltages) || $name_rest_at(&state, voltages, apart) != $NAME_OK) {
        alarm($NAME_NOT_FINITE);
        return;
    }
    read_displacements(measured);
    for (m = 0; m < $NAME_OUTPUTS; m++) {
        apart[m] -= measured[m];
        if (!(apart[m] - apart[m] <= R(0))) {
            alarm($NAME_NOT_FINITE);
            return;
        }
    }
    for (ahead = 0; ahead < $NAME_PREVIEW; ahead++) {
        take_references(references, apart);
        (void)$name_know(&state, references);
    }
    while (samples-- > 0) {
        $name_status status;
        wait_for_tick();
        write_voltages(voltages);
        take_references(references, apart);
        status = $name_step(&state, references, voltages);
        if (status != $NAME_OK) {
            alarm(status); /* the voltages keep to their limits all the same */
        }
    }
}
