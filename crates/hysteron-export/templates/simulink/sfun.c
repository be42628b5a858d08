$DESCRIPTION
/*
 * A Simulink S-function (C MEX, level 2) around $name.c. In MATLAB, in the folder of these files:
 *
 *     mex $name_sfun.c $name.c
 *
 * then a block "S-Function" of the name $name_sfun, with the voltage that it rests at first as its
//{ inverse
 * parameter. In: the reference [$OUTPUT_UNIT], the newest known, $N_PREVIEW samples ahead. Out: the voltage
 * [$INPUT_UNIT] for the next period.
//}
//{ !inverse
 * parameter. In: the voltage [$INPUT_UNIT]. Out: the displacement [$OUTPUT_UNIT] at the end of it.
//}
 * A sample takes 1/$RATE s.
 *
 * The outputs are computed on a copy, which the update keeps: the solver may ask for outputs as often as it
 * likes.
 */
#define S_FUNCTION_NAME $name_sfun
#define S_FUNCTION_LEVEL 2

#include <string.h>

#include "simstruc.h"

#include "$name.h"

/* Work vectors, of doubles so that they are aligned: what is remembered, and the copy. */
#define KEPT 0
#define NEXT 1
#define WORDS ((int_T)((sizeof($name_state) + sizeof(real_T) - 1) / sizeof(real_T)))

static $name_state *state_of(SimStruct *S, int_T which)
{
    return ($name_state *)ssGetDWork(S, which);
}

/* The voltage that the block rests at first: its parameter. */
static int rest_voltage(SimStruct *S, $name_real *voltage)
{
    const mxArray *given = ssGetSFcnParam(S, 0);
    if (!mxIsDouble(given) || mxIsComplex(given) || mxGetNumberOfElements(given) != 1) {
        return 0;
    }
    *voltage = ($name_real)mxGetScalar(given);
    return 1;
}

#define MDL_CHECK_PARAMETERS
static void mdlCheckParameters(SimStruct *S)
{
    $name_real voltage;
    if (!rest_voltage(S, &voltage)) {
        ssSetErrorStatus(S, "$name: the parameter is the voltage at rest, one real number");
    }
}

static void mdlInitializeSizes(SimStruct *S)
{
    int_T i;
    ssSetNumSFcnParams(S, 1);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) {
        return; /* Simulink says so. */
    }
    mdlCheckParameters(S);
    if (ssGetErrorStatus(S) != NULL) {
        return;
    }
    ssSetSFcnParamTunable(S, 0, 0);
    ssSetNumContStates(S, 0);
    ssSetNumDiscStates(S, 0);
    if (!ssSetNumInputPorts(S, 1)) {
        return;
    }
    ssSetInputPortWidth(S, 0, 1);
    ssSetInputPortRequiredContiguous(S, 0, 1);
    ssSetInputPortDirectFeedThrough(S, 0, 1);
    if (!ssSetNumOutputPorts(S, 1)) {
        return;
    }
    ssSetOutputPortWidth(S, 0, 1);
    ssSetNumSampleTimes(S, 1);
    if (!ssSetNumDWork(S, 2)) {
        return;
    }
    for (i = KEPT; i <= NEXT; i++) {
        ssSetDWorkWidth(S, i, WORDS);
        ssSetDWorkDataType(S, i, SS_DOUBLE);
    }
    ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE);
}

static void mdlInitializeSampleTimes(SimStruct *S)
{
    ssSetSampleTime(S, 0, 1.0 / (real_T)$NAME_SAMPLE_RATE_HZ);
    ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_START
static void mdlStart(SimStruct *S)
{
    $name_real voltage, displacement;
    $name_init(state_of(S, KEPT));
    if (!rest_voltage(S, &voltage) || $name_rest_at(state_of(S, KEPT), voltage, &displacement) < $NAME_OK) {
        ssSetErrorStatus(S, "$name: the voltage at rest is not finite or out of range");
    }
    memcpy(state_of(S, NEXT), state_of(S, KEPT), sizeof($name_state));
}

static void mdlOutputs(SimStruct *S, int_T tid)
{
    const real_T *in = ssGetInputPortRealSignal(S, 0);
    real_T *out = ssGetOutputPortRealSignal(S, 0);
    $name_real result;
    (void)tid;
    memcpy(state_of(S, NEXT), state_of(S, KEPT), sizeof($name_state));
    if ($name_step(state_of(S, NEXT), ($name_real)in[0], &result) < $NAME_OK) {
        ssSetErrorStatus(S, "$name: an input is not finite or out of range");
    }
    out[0] = (real_T)result;
}

#define MDL_UPDATE
static void mdlUpdate(SimStruct *S, int_T tid)
{
    (void)tid;
    memcpy(state_of(S, KEPT), state_of(S, NEXT), sizeof($name_state));
}

static void mdlTerminate(SimStruct *S)
{
    (void)S;
}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
