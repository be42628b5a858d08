/* Start of a program on a Cortex-M4 or M7: floating-point unit on, memory set up, main, exit through
   semihosting. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t data_begin, data_end, data_load, bss_begin, bss_end, stack_top;
extern void initialise_monitor_handles(void);
extern int main(void);

/* The library's exit calls them. */
void _init(void)
{
}

void _fini(void)
{
}

void reset(void)
{
    uint32_t *from = &data_load, *to;
    /* CPACR: full access to coprocessors 10 and 11. */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n isb");
    for (to = &data_begin; to < &data_end; to++) {
        *to = *from++;
    }
    for (to = &bss_begin; to < &bss_end; to++) {
        *to = 0;
    }
    initialise_monitor_handles();
    exit(main());
}

static void fault(void)
{
    abort();
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    &stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault
};
