/* As much of simstruc.h as the exported S-function uses, for a block of one input and one output. */
#ifndef SIMSTRUC_H
#define SIMSTRUC_H

#include <stddef.h>

typedef double real_T;
typedef int int_T;
typedef struct {
    double value;
    int is_double;
} mxArray;

#define SS_DOUBLE 0
#define SS_OPTION_EXCEPTION_FREE_CODE 1u
#define MOST_WORDS 100000

typedef struct {
    const char *error;
    mxArray parameter;
    int_T parameters, parameters_given, tunable, inputs, outputs, works, times, words[2], contiguous, feeds;
    int_T input_width, output_width;
    unsigned options;
    real_T in, out, period, offset, work[2][MOST_WORDS];
} SimStruct;

#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssGetErrorStatus(S) ((S)->error)
#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) ((S)->parameters_given)
#define ssGetSFcnParam(S, i) ((i) == 0 ? &(S)->parameter : NULL)
#define ssSetSFcnParamTunable(S, i, is) ((S)->tunable = (i) == 0 && (is))
#define ssSetNumContStates(S, n) ((void)(S), (void)(n))
#define ssSetNumDiscStates(S, n) ((void)(S), (void)(n))
#define ssSetNumInputPorts(S, n) ((S)->inputs = (n))
#define ssSetInputPortWidth(S, i, n) ((S)->input_width = (n))
#define ssSetInputPortRequiredContiguous(S, i, is) ((S)->contiguous = (is))
#define ssSetInputPortDirectFeedThrough(S, i, is) ((S)->feeds = (is))
#define ssSetNumOutputPorts(S, n) ((S)->outputs = (n))
#define ssSetOutputPortWidth(S, i, n) ((S)->output_width = (n))
#define ssSetNumSampleTimes(S, n) ((S)->times = (n))
#define ssSetNumDWork(S, n) ((S)->works = (n))
#define ssSetDWorkWidth(S, i, n) ((S)->words[i] = (n))
#define ssSetDWorkDataType(S, i, type) ((void)(type))
#define ssSetOptions(S, o) ((S)->options = (o))
#define ssSetSampleTime(S, i, t) ((S)->period = (t))
#define ssSetOffsetTime(S, i, t) ((S)->offset = (t))
#define ssGetDWork(S, i) ((void *)(S)->work[i])
#define ssGetInputPortRealSignal(S, i) ((const real_T *)&(S)->in)
#define ssGetOutputPortRealSignal(S, i) (&(S)->out)
#define mxIsDouble(a) ((a)->is_double)
#define mxIsComplex(a) ((void)(a), 0)
#define mxGetNumberOfElements(a) ((void)(a), 1)
#define mxGetScalar(a) ((a)->value)

#endif
