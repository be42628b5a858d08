/* Answers calls, three doubles each (which, and two numbers), by two doubles each: status and output. */
#include <stdio.h>

#include "MODEL.h"

int main(void)
{
    static MODEL_state state;
    double call[3], answer[2];
    MODEL_real y = 0;
    MODEL_init(&state);
    while (fread(call, sizeof call, 1, stdin) == 1) {
        MODEL_status status;
        if (call[0] < 1.0) {
            status = MODEL_step(&state, (MODEL_real)call[1], &y);
        } else if (call[0] < 2.0) {
            status = MODEL_rest_at(&state, (MODEL_real)call[1], &y);
        } else {
            status = MODEL_start_at(&state, (MODEL_real)call[1], (MODEL_real)call[2]);
        }
        answer[0] = (double)status;
        answer[1] = (double)y;
        if (fwrite(answer, sizeof answer, 1, stdout) != 1 || fflush(stdout) != 0) {
            return 1;
        }
    }
    return 0;
}
