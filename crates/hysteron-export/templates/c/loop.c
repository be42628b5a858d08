/* A control loop around $name: reference in, voltage out, once a sample. Written by hysteron export; replace the four functions below by those of
 * your hardware.
 *
 * Timing of a period T = 1/$NAME_SAMPLE_RATE_HZ s, the sample timer ticking at its beginning:
 *   1. The voltage computed in the period before goes to the converter at once: every voltage leaves exactly T after the one before, whatever the
 *      computation took. It is this held voltage that the compensator was made for.
 *   2. The next reference is taken ($NAME_PREVIEW samples ahead) and the next voltage computed. This may take any time below T.
 * The voltage put out at a tick was computed one tick earlier: count this one period, and the time the converter and the amplifier take, as
 * delay (a model identified from drive and response as the controller sees them has it in its delay already).
 * A measured displacement is used to start without a jump; the loop is feedforward. */
#include "$name.h"

extern void wait_for_tick(void);                     /* returns at the beginning of a period */
extern $name_real next_reference(void);              /* [$OUTPUT_UNIT] */
extern $name_real read_displacement(void);           /* analogue-to-digital converter [$OUTPUT_UNIT] */
extern void write_voltage($name_real voltage);       /* digital-to-analogue converter and amplifier [$INPUT_UNIT] */
extern void alarm($name_status status);

void control_loop(unsigned long samples);

void control_loop(unsigned long samples)
{
    static $name_state state;
    $name_real voltage = $NAME_VOLTAGE_LOW > R(0) ? $NAME_VOLTAGE_LOW : R(0), displacement;
    int ahead;
    $name_init(&state);
    /* The stage stands, without memory, at this voltage; what it is measured at is what the reference counts from. */
    write_voltage(voltage);
    (void)$name_rest_at(&state, voltage, &displacement);
    if ($name_measured_at_rest(&state, read_displacement()) != $NAME_OK) {
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
