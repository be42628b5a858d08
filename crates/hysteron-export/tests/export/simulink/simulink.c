/* A master in the place of Simulink's: first the voltage at rest, then one input after the other from the
   standard input; the outputs to the standard output. Every output is asked for twice, the first time with
   another input, as a solver may. */
#include <stdio.h>

static int failed(SimStruct *S)
{
    if (S->error != NULL) {
        fprintf(stderr, "%s\n", S->error);
        return 1;
    }
    return 0;
}

int main(void)
{
    static SimStruct block;
    SimStruct *S = &block;
    double in;
    if (fread(&S->parameter.value, sizeof(double), 1, stdin) != 1) {
        return 2;
    }
    S->parameters_given = 1;
    mdlInitializeSizes(S);
    if (!failed(S)) {
        fprintf(stderr, "a parameter that is no number was taken\n");
        return 3;
    }
    S->error = NULL;
    S->parameter.is_double = 1;
    mdlInitializeSizes(S);
    mdlInitializeSampleTimes(S);
    if (failed(S) || S->inputs != 1 || S->outputs != 1 || S->input_width != 1 || S->output_width != 1
        || S->works != 2 || S->words[0] > MOST_WORDS || S->words[1] != S->words[0] || S->times != 1
        || S->period <= 0.0 || !S->feeds || !S->contiguous) {
        return 4;
    }
    mdlStart(S);
    while (!failed(S) && fread(&in, sizeof in, 1, stdin) == 1) {
        S->in = 0.5 * in + 1.0;
        mdlOutputs(S, 0);
        S->in = in;
        mdlOutputs(S, 0);
        mdlUpdate(S, 0);
        fwrite(&S->out, sizeof S->out, 1, stdout);
    }
    mdlTerminate(S);
    return failed(S) ? 5 : 0;
}
