/* Instructions of a sample, with every instruction lasting 1 ns of the simulator's time (-icount shift=0) and
   the system timer counting that time at 25 MHz: a tick is 40 instructions. The overhead of the loop is taken
   off. */
#include <stdint.h>
#include <stdio.h>

#include "MODEL.h"

#define SAMPLES 2000
#define CONTROL (*(volatile uint32_t *)0xE000E010u)
#define RELOAD (*(volatile uint32_t *)0xE000E014u)
#define NOW (*(volatile uint32_t *)0xE000E018u)

static MODEL_state state;
static MODEL_real drive[SAMPLES];
static volatile MODEL_real sink;

static uint32_t ticks(int steps)
{
    uint32_t before, after;
    MODEL_real y = 0;
    int k;
    MODEL_init(&state);
    before = NOW;
    for (k = 0; k < SAMPLES; k++) {
        if (steps) {
            (void)MODEL_step(&state, drive[k], &y);
        } else {
            y = drive[k];
        }
        sink = y;
    }
    after = NOW;
    return (before - after) & 0xFFFFFFu;
}

static double worst(void)
{
    uint32_t most = 0;
    MODEL_real y = 0;
    int k;
    MODEL_init(&state);
    for (k = 0; k < SAMPLES; k++) {
        const uint32_t before = NOW;
        uint32_t after;
        (void)MODEL_step(&state, drive[k], &y);
        after = (before - NOW) & 0xFFFFFFu;
        most = after > most ? after : most;
    }
    return 40.0 * most;
}

int main(void)
{
    int k;
    for (k = 0; k < SAMPLES; k++) {
        /* A triangle of 200 samples, 0 to 100 V, or what a displacement makes of it. */
        const int at = k % 200;
        drive[k] = (MODEL_real)(SCALE * (at < 100 ? at : 200 - at));
    }
    RELOAD = 0xFFFFFFu;
    CONTROL = 5u;
    {
        const uint32_t with = ticks(1), without = ticks(0);
        printf("instructions %.0f mean %.0f worst state %u\n", 40.0 * (with - without) / SAMPLES,
               worst(), (unsigned)sizeof state);
    }
    return 0;
}
