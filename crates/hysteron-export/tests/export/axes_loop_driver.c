/* The example loop of several axes with the exported model as its stage, its power cycled at voltages. Arguments:
   the voltage, whether it is known afterwards, samples. Prints the largest step of the first actuator [V], the
   largest voltage of either, the displacements less their references at the end, the worst, and the alarms. */
#include <stdio.h>
#include <stdlib.h>

#include "held.h"
#include "held_inverse.h"

extern void control_loop(uint32_t samples);
extern void wait_for_tick(void);
extern void next_references(double references[HELD_OUTPUTS]);
extern void read_displacements(double outputs[HELD_OUTPUTS]);
extern bool present_voltages(double voltages[HELD_INPUTS]);
extern void write_voltages(const double voltages[HELD_INPUTS]);
extern void alarm(held_inverse_status status);

static held_state stage;
static double put_out[HELD_INPUTS], displacement[HELD_OUTPUTS];
static double largest_step, largest;
static unsigned long alarms;
static bool known;

void wait_for_tick(void)
{
    (void)held_step(&stage, put_out, displacement);
}

void next_references(double references[HELD_OUTPUTS])
{
    references[0] = 0.3;
    references[1] = -0.1;
}

void read_displacements(double outputs[HELD_OUTPUTS])
{
    outputs[0] = displacement[0];
    outputs[1] = displacement[1];
}

bool present_voltages(double voltages[HELD_INPUTS])
{
    int i;
    for (i = 0; i < HELD_INPUTS; i++) {
        voltages[i] = known ? put_out[i] : 0.2;
    }
    return known;
}

static double size(double x)
{
    return x < 0.0 ? -x : x;
}

void write_voltages(const double voltages[HELD_INPUTS])
{
    static bool first = true;
    int i;
    /* The error of a guess is a step by itself. */
    if ((known || !first) && size(voltages[0] - put_out[0]) > largest_step) {
        largest_step = size(voltages[0] - put_out[0]);
    }
    first = false;
    for (i = 0; i < HELD_INPUTS; i++) {
        largest = size(voltages[i]) > largest ? size(voltages[i]) : largest;
        put_out[i] = voltages[i];
    }
}

void alarm(held_inverse_status status)
{
    alarms += status < HELD_INVERSE_OK;
}

int main(int count, char **arguments)
{
    double wanted[HELD_OUTPUTS], worst = 0.0;
    int k, m;
    if (count != 4) {
        return 2;
    }
    known = atoi(arguments[2]) != 0;
    held_init(&stage);
    for (k = 0; k < 20000; k++) {
        put_out[0] = put_out[1] = atof(arguments[1]) * (k < 10000 ? k / 10000.0 : 1.0);
        wait_for_tick();
    }
    control_loop((uint32_t)strtoul(arguments[3], NULL, 10));
    next_references(wanted);
    for (m = 0; m < HELD_OUTPUTS; m++) {
        worst = size(displacement[m] - wanted[m]) > worst ? size(displacement[m] - wanted[m]) : worst;
    }
    printf("%.9g %.9g %.9g %lu\n", largest_step, largest, worst, alarms);
    return 0;
}
