/* The example loop with the exported model as its stage: driven to a peak and back, the power is cycled at
   that voltage, and the loop starts again. Arguments: peak, voltage at the cycle, whether it is known
   afterwards, reference, samples. Prints the largest step [V], the displacement, and the alarms of the last
   quarter. */
#include <stdio.h>
#include <stdlib.h>

#include "MODEL.h"
#include "MODEL_inverse.h"

extern void control_loop(uint32_t samples);
extern void wait_for_tick(void);
extern MODEL_inverse_real next_reference(void);
extern MODEL_inverse_real read_displacement(void);
extern bool present_voltage(MODEL_inverse_real *voltage);
extern void write_voltage(MODEL_inverse_real voltage);
extern void alarm(MODEL_inverse_status status);

static MODEL_state stage;
static MODEL_real put_out, displacement;
static MODEL_inverse_real reference;
static double largest;
static unsigned long taken, late, alarms;
static bool known;

void wait_for_tick(void)
{
    (void)MODEL_step(&stage, put_out, &displacement);
}

MODEL_inverse_real next_reference(void)
{
    taken++;
    return reference;
}

MODEL_inverse_real read_displacement(void)
{
    return displacement;
}

bool present_voltage(MODEL_inverse_real *voltage)
{
    *voltage = put_out;
    return known;
}

void write_voltage(MODEL_inverse_real voltage)
{
    const double step = (double)voltage - (double)put_out;
    largest = step > largest ? step : -step > largest ? -step : largest;
    put_out = voltage;
}

void alarm(MODEL_inverse_status status)
{
    (void)status;
    alarms += taken > late;
}

static void go_to(double voltage)
{
    int k;
    while ((double)put_out < voltage || (double)put_out > voltage) {
        const double left = voltage - (double)put_out;
        put_out = (MODEL_real)(left > 0.5    ? (double)put_out + 0.5
                               : left < -0.5 ? (double)put_out - 0.5 : voltage);
        wait_for_tick();
    }
    for (k = 0; k < 20000; k++) {
        wait_for_tick();
    }
}

int main(int count, char **arguments)
{
    unsigned long samples;
    if (count != 6) {
        return 2;
    }
    known = atoi(arguments[3]) != 0;
    reference = (MODEL_inverse_real)atof(arguments[4]);
    samples = strtoul(arguments[5], NULL, 10);
    late = samples - samples / 4;
    MODEL_init(&stage);
    go_to(atof(arguments[1]));
    go_to(atof(arguments[2]));
    control_loop((uint32_t)samples);
    printf("%.9g %.9g %lu\n", largest, (double)displacement, alarms);
    return 0;
}
