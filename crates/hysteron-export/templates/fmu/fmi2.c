/* FMI 2.0 co-simulation around $name.c. Written by hysteron export. */
#include "fmi2_types.h"

#include "instance.h"

#define STATUS(holds) ((holds) ? fmi2OK : fmi2Error)

typedef struct {
    fmu_instance common;
    fmi2CallbackLogger logger;
} instance;

static void forward(void *environment, const char *name, const char *message, int is_error)
{
    const instance *own = environment;
    if (own->logger != NULL) {
        own->logger(own->common.log_function, name, is_error ? fmi2Error : fmi2Warning, "model", "%s",
                    message);
    }
}

FMU_EXPORT const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

FMU_EXPORT const char *fmi2GetVersion(void)
{
    return "2.0";
}

FMU_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                          const fmi2String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

FMU_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String place,
                                         const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                         fmi2Boolean logging)
{
    fmu_instance *common;
    instance *own;
    (void)place, (void)visible, (void)logging;
    if (type != fmi2CoSimulation) {
        return NULL;
    }
    common = fmu_new(name, token);
    own = common != NULL ? calloc(1, sizeof *own) : NULL;
    if (own != NULL) {
        own->common = *common;
        own->common.log = forward;
        own->common.environment = own;
        if (functions != NULL) {
            own->logger = functions->logger;
            own->common.log_function = functions->componentEnvironment;
        }
    }
    free(common);
    return own;
}

FMU_EXPORT void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

FMU_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                          fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    fmu_begin(c, start);
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return STATUS(fmu_enter(c, FMU_INITIALIZING));
}

FMU_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return STATUS(fmu_enter(c, FMU_STEPPING));
}

FMU_EXPORT fmi2Status fmi2Terminate(fmi2Component c)
{
    ((fmu_instance *)c)->now.phase = FMU_TERMINATED;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2Reset(fmi2Component c)
{
    fmu_clear(c);
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                  fmi2Real values[])
{
    return STATUS(fmu_get_all(c, references, n, values));
}

FMU_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                  const fmi2Real values[])
{
    return STATUS(fmu_set_all(c, references, n, values));
}

FMU_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                     fmi2Integer values[])
{
    return STATUS(fmu_get_status(c, references, n, values));
}

/* There are no variables of the other types: nothing to get or set but of none. */
#define NONE_OF_A_TYPE(name, type)                                                               \
    FMU_EXPORT fmi2Status name(fmi2Component c, const fmi2ValueReference references[], size_t n, \
                               type values[])                                                    \
    {                                                                                            \
        (void)references, (void)values;                                                          \
        return STATUS(n == 0 || fmu_fail(c, #name ": there is no such variable"));               \
    }
NONE_OF_A_TYPE(fmi2GetBoolean, fmi2Boolean)
NONE_OF_A_TYPE(fmi2GetString, fmi2String)
NONE_OF_A_TYPE(fmi2SetInteger, const fmi2Integer)
NONE_OF_A_TYPE(fmi2SetBoolean, const fmi2Boolean)
NONE_OF_A_TYPE(fmi2SetString, const fmi2String)

FMU_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return STATUS(fmu_save(&((fmu_instance *)c)->now, state));
}

FMU_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return STATUS(fmu_restore(c, state));
}

FMU_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = FMU_SAVED_BYTES;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                            size_t size)
{
    return STATUS(fmu_write(c, state, bytes, size));
}

FMU_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                              fmi2FMUstate *state)
{
    return STATUS(fmu_read(c, bytes, size, state));
}

FMU_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                                   size_t n_unknowns, const fmi2ValueReference knowns[],
                                                   size_t n_knowns, const fmi2Real seed[],
                                                   fmi2Real sensitivity[])
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)sensitivity;
    return STATUS(fmu_fail(c, "derivatives are not provided"));
}

FMU_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                                  size_t n, const fmi2Integer orders[],
                                                  const fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return STATUS(n == 0 || fmu_fail(c, "inputs are held over a communication step"));
}

FMU_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                                   size_t n, const fmi2Integer orders[], fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return STATUS(n == 0 || fmu_fail(c, "derivatives are not provided"));
}

FMU_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean no_return)
{
    (void)no_return;
    return STATUS(fmu_step(c, time, length));
}

FMU_EXPORT fmi2Status fmi2CancelStep(fmi2Component c)
{
    return STATUS(fmu_fail(c, "no step is pending"));
}

FMU_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c, (void)kind;
    *value = fmi2OK;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    (void)kind;
    *value = ((fmu_instance *)c)->now.time;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c, (void)kind;
    *value = 0;
    return fmi2Discard;
}

FMU_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c, (void)kind;
    *value = 0;
    return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)c, (void)kind;
    *value = "";
    return fmi2Discard;
}
