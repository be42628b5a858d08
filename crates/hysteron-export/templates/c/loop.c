/* A control loop around $name: reference in, voltage out, once a sample. Written by hysteron export; replace
 * the six functions below by those of your hardware.
 *
 * Timing of a period T = 1/$NAME_SAMPLE_RATE_HZ s, the sample timer ticking at its beginning:
 *   1. The voltage computed in the period before goes to the converter at once: every voltage leaves exactly
 *      T after the one before, whatever the computation took. It is this held voltage that the compensator
 *      was made for.
 *   2. The next reference is taken ($NAME_PREVIEW samples ahead) and the next voltage computed. This may take
 *      any time below T.
 * The voltage put out at a tick was computed one tick earlier: count this one period, and the time the
 * converter and the amplifier take, as delay (a model identified from drive and response as the controller
 * sees them has it in its delay already).
 *
 * Start, also after a power cycle with the stage anywhere; never by more than $NAME_VOLTAGE_STEP a sample:
 *   - where it is known what the converter puts out (read back, or remembered over the reset), the stage is
 *     taken over there, at rest;
 *   - where it is not, the voltage goes from the best guess to the one next to 0 within the limits, and waits
 *     SETTLES samples there. The error of the guess causes one step.
 * Then the displacement is measured, and the reference counts from it. What the hysteresis remembers from
 * before is not known: the stage is taken for driven here without turning, from the voltage next to 0 or from
 * the guess. After this the loop is feedforward. */
#include "$name.h"

/* $SETTLES_IN_WORDS */
#define SETTLES $SETTLESUL

extern void wait_for_tick(void);                     /* returns at the beginning of a period */
extern $name_real next_reference(void);              /* [$OUTPUT_UNIT] */
extern $name_real read_displacement(void);           /* analogue-to-digital converter [$OUTPUT_UNIT] */
extern bool present_voltage($name_real *voltage);     /* what the converter puts out now [$INPUT_UNIT]:
                                                        1 where it is known, 0 where it is a guess */
extern void write_voltage($name_real voltage);       /* digital-to-analogue converter and amplifier
                                                        [$INPUT_UNIT] */
extern void alarm($name_status status);

void control_loop(uint32_t samples);

static $name_real within($name_real x, $name_real low, $name_real high)
{
    return x < low ? low : x > high ? high : x;
}

void control_loop(uint32_t samples)
{
    static $name_state state;
    const $name_real rest = within(R(0), $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH);
    $name_real from = rest, voltage, there, displacement;
    const bool known = present_voltage(&from);
    int32_t ahead;
    $name_init(&state);
    if ($name_rest_at(&state, from, &displacement) != $NAME_OK) {
        alarm($NAME_NOT_FINITE);
        return;
    }
    there = known ? within(from, $NAME_VOLTAGE_LOW, $NAME_VOLTAGE_HIGH) : rest;
    for (voltage = from; voltage < there || voltage > there;) {
        wait_for_tick();
        voltage = within(there, voltage - $NAME_VOLTAGE_STEP, voltage + $NAME_VOLTAGE_STEP);
        write_voltage(voltage);
    }
    if (!known || from < there || from > there) {
        uint32_t waited;
        for (waited = 0; waited < SETTLES; waited++) {
            wait_for_tick();
        }
    }
    if ($name_rest_after(&state, known ? rest : from, voltage, &displacement) != $NAME_OK ||
        $name_measured_at_rest(&state, read_displacement()) != $NAME_OK) {
        alarm($NAME_NOT_FINITE);
        return;
    }
    for (ahead = 0; ahead < $NAME_PREVIEW; ahead++) {
        (void)$name_know(&state, next_reference());
    }
    while (samples-- > 0) {
        $name_status status;
        wait_for_tick();
        write_voltage(voltage);
        status = $name_step(&state, next_reference(), &voltage);
        if (status != $NAME_OK) {
            alarm(status); /* the voltage keeps to its limits all the same */
        }
    }
}
