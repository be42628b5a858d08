/* FMI 3.0 co-simulation around $name.c. Written by hysteron export. */
#include "fmi3_types.h"

#include "instance.h"

#define STATUS(holds) ((holds) ? fmi3OK : fmi3Error)

typedef struct {
    fmu_instance common;
    fmi3LogMessageCallback logger;
} instance;

static void forward(void *environment, const char *name, const char *message, int is_error)
{
    const instance *own = environment;
    (void)name;
    if (own->logger != NULL) {
        own->logger(own->common.log_function, is_error ? fmi3Error : fmi3Warning, "model", message);
    }
}

FMU_EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

FMU_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n,
                                          const fmi3String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

FMU_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place,
                                                    fmi3Boolean visible, fmi3Boolean logging,
                                                    fmi3Boolean events, fmi3Boolean early_return,
                                                    const fmi3ValueReference intermediate[],
                                                    size_t n_intermediate,
                                                    fmi3InstanceEnvironment environment,
                                                    fmi3LogMessageCallback logger,
                                                    fmi3IntermediateUpdateCallback update)
{
    fmu_instance *common = fmu_new(name, token);
    instance *own = common != NULL ? calloc(1, sizeof *own) : NULL;
    (void)place, (void)visible, (void)logging, (void)events, (void)early_return, (void)intermediate,
        (void)n_intermediate, (void)update;
    if (own != NULL) {
        own->common = *common;
        own->common.log = forward;
        own->common.environment = own;
        own->logger = logger;
        own->common.log_function = environment;
    }
    free(common);
    return own;
}

FMU_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place,
                                                     fmi3Boolean visible, fmi3Boolean logging,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback logger)
{
    (void)name, (void)token, (void)place, (void)visible, (void)logging, (void)environment, (void)logger;
    return NULL;
}

FMU_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String place,
                                                          fmi3Boolean visible, fmi3Boolean logging,
                                                          fmi3InstanceEnvironment environment,
                                                          fmi3LogMessageCallback logger,
                                                          fmi3ClockUpdateCallback update,
                                                          fmi3LockPreemptionCallback lock,
                                                          fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)place, (void)visible, (void)logging, (void)environment, (void)logger;
    (void)update, (void)lock, (void)unlock;
    return NULL;
}

FMU_EXPORT void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

FMU_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance,
                                                  fmi3Float64 tolerance, fmi3Float64 start,
                                                  fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    fmu_begin(c, start);
    return STATUS(fmu_enter(c, FMU_INITIALIZING));
}

FMU_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return STATUS(fmu_enter(c, FMU_STEPPING));
}

FMU_EXPORT fmi3Status fmi3Terminate(fmi3Instance c)
{
    ((fmu_instance *)c)->now.phase = FMU_TERMINATED;
    return fmi3OK;
}

FMU_EXPORT fmi3Status fmi3Reset(fmi3Instance c)
{
    fmu_clear(c);
    return fmi3OK;
}

FMU_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                     fmi3Float64 values[], size_t n_values)
{
    return STATUS((n == n_values || fmu_fail(c, "one value a variable is wanted"))
                  && fmu_get_all(c, references, n, values));
}

FMU_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                     const fmi3Float64 values[], size_t n_values)
{
    return STATUS((n == n_values || fmu_fail(c, "one value a variable is wanted"))
                  && fmu_set_all(c, references, n, values));
}

FMU_EXPORT fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                   fmi3Int32 values[], size_t n_values)
{
    return STATUS((n == n_values || fmu_fail(c, "one value a variable is wanted"))
                  && fmu_get_status(c, references, n, values));
}

/* There are no variables of the other types: nothing to get or set but of none. */
#define NONE_OF_A_TYPE(name, type)                                                              \
    FMU_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference references[], size_t n, \
                               type values[], size_t n_values)                                  \
    {                                                                                           \
        (void)references, (void)values, (void)n_values;                                         \
        return STATUS(n == 0 || fmu_fail(c, #name ": there is no such variable"));              \
    }
#define NONE_OF(type)                                \
    NONE_OF_A_TYPE(fmi3Get##type, fmi3##type)        \
    NONE_OF_A_TYPE(fmi3Set##type, const fmi3##type)
NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF_A_TYPE(fmi3SetInt32, const fmi3Int32)
NONE_OF(UInt32)
NONE_OF(Int64)
NONE_OF(UInt64)
NONE_OF(Boolean)
NONE_OF(String)

FMU_EXPORT fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                    size_t sizes[], fmi3Binary values[], size_t n_values)
{
    (void)references, (void)sizes, (void)values, (void)n_values;
    return STATUS(n == 0 || fmu_fail(c, "there are no binary variables"));
}

FMU_EXPORT fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                    const size_t sizes[], const fmi3Binary values[], size_t n_values)
{
    (void)references, (void)sizes, (void)values, (void)n_values;
    return STATUS(n == 0 || fmu_fail(c, "there are no binary variables"));
}

/* Clocks: there are none. */
#define NO_CLOCK(name, ...)                                                                                  \
    FMU_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference references[], size_t n, __VA_ARGS__) \
    {                                                                                                        \
        (void)references
#define END_OF_NO_CLOCK                                           \
    return STATUS(n == 0 || fmu_fail(c, "there are no clocks")); \
    }
NO_CLOCK(fmi3GetClock, fmi3Clock values[]), (void)values;
END_OF_NO_CLOCK
NO_CLOCK(fmi3SetClock, const fmi3Clock values[]), (void)values;
END_OF_NO_CLOCK
NO_CLOCK(fmi3GetIntervalDecimal, fmi3Float64 values[], fmi3IntervalQualifier q[]), (void)values, (void)q;
END_OF_NO_CLOCK
NO_CLOCK(fmi3GetIntervalFraction, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier q[]),
    (void)a, (void)b, (void)q;
END_OF_NO_CLOCK
NO_CLOCK(fmi3GetShiftDecimal, fmi3Float64 values[]), (void)values;
END_OF_NO_CLOCK
NO_CLOCK(fmi3GetShiftFraction, fmi3UInt64 a[], fmi3UInt64 b[]), (void)a, (void)b;
END_OF_NO_CLOCK
NO_CLOCK(fmi3SetIntervalDecimal, const fmi3Float64 values[]), (void)values;
END_OF_NO_CLOCK
NO_CLOCK(fmi3SetIntervalFraction, const fmi3UInt64 a[], const fmi3UInt64 b[]), (void)a, (void)b;
END_OF_NO_CLOCK
NO_CLOCK(fmi3SetShiftDecimal, const fmi3Float64 values[]), (void)values;
END_OF_NO_CLOCK
NO_CLOCK(fmi3SetShiftFraction, const fmi3UInt64 a[], const fmi3UInt64 b[]), (void)a, (void)b;
END_OF_NO_CLOCK

FMU_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference reference,
                                                          size_t *n)
{
    (void)reference;
    *n = 0;
    return STATUS(fmu_fail(c, "dependencies are in modelDescription.xml"));
}

FMU_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                                  size_t elements_of_dependent[],
                                                  fmi3ValueReference independents[],
                                                  size_t elements_of_independents[],
                                                  fmi3DependencyKind kinds[], size_t n)
{
    (void)dependent, (void)elements_of_dependent, (void)independents, (void)elements_of_independents,
        (void)kinds, (void)n;
    return STATUS(fmu_fail(c, "dependencies are in modelDescription.xml"));
}

FMU_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return STATUS(fmu_save(&((fmu_instance *)c)->now, state));
}

FMU_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return STATUS(fmu_restore(c, state));
}

FMU_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

FMU_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c, (void)state;
    *size = FMU_SAVED_BYTES;
    return fmi3OK;
}

FMU_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return STATUS(fmu_write(c, state, bytes, size));
}

FMU_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                              fmi3FMUState *state)
{
    return STATUS(fmu_read(c, bytes, size, state));
}

#define NO_DERIVATIVE(name)                                                                            \
    FMU_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns, \
                               const fmi3ValueReference knowns[], size_t n_knowns,                     \
                               const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],     \
                               size_t n_sensitivity)                                                   \
    {                                                                                                  \
        (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed;      \
        (void)sensitivity, (void)n_sensitivity;                                                        \
        return STATUS(fmu_fail(c, "derivatives are not provided"));                                    \
    }
NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)

/* Modes that this FMU does not have. */
#define NO_MODE(name)                                                  \
    FMU_EXPORT fmi3Status name(fmi3Instance c)                         \
    {                                                                  \
        return STATUS(fmu_fail(c, #name ": there is no such mode")); \
    }
NO_MODE(fmi3EnterConfigurationMode)
NO_MODE(fmi3ExitConfigurationMode)
NO_MODE(fmi3EnterEventMode)
NO_MODE(fmi3EnterStepMode)
NO_MODE(fmi3EvaluateDiscreteStates)

FMU_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                               fmi3Boolean *nominals, fmi3Boolean *values,
                                               fmi3Boolean *has_next, fmi3Float64 *next)
{
    *again = *terminate = *nominals = *values = *has_next = false;
    *next = 0.0;
    return STATUS(fmu_fail(c, "there is no event mode"));
}

FMU_EXPORT fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference references[],
                                               size_t n, const fmi3Int32 orders[], fmi3Float64 values[],
                                               size_t n_values)
{
    (void)references, (void)orders, (void)values, (void)n_values;
    return STATUS(n == 0 || fmu_fail(c, "derivatives are not provided"));
}

FMU_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_return,
                                 fmi3Boolean *events, fmi3Boolean *terminate, fmi3Boolean *early,
                                 fmi3Float64 *last)
{
    const int holds = fmu_step(c, time, length);
    (void)no_return;
    *events = *terminate = *early = false;
    *last = ((fmu_instance *)c)->now.time;
    return STATUS(holds);
}

/* Functions of the other two types of interface, which the loaders of some tools look for all the same. */
NO_MODE(fmi3EnterContinuousTimeMode)

#define NOT_THIS_TYPE(name, ...)                                               \
    FMU_EXPORT fmi3Status name(fmi3Instance c, __VA_ARGS__)                    \
    {                                                                          \
        return STATUS(fmu_fail(c, #name ": this FMU is for co-simulation")); \
    }
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
NOT_THIS_TYPE(fmi3CompletedIntegratorStep, fmi3Boolean no_return, fmi3Boolean *events, fmi3Boolean *terminate)
NOT_THIS_TYPE(fmi3SetTime, fmi3Float64 time)
NOT_THIS_TYPE(fmi3SetContinuousStates, const fmi3Float64 states[], size_t n)
NOT_THIS_TYPE(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t n)
NOT_THIS_TYPE(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t n)
NOT_THIS_TYPE(fmi3GetContinuousStates, fmi3Float64 states[], size_t n)
NOT_THIS_TYPE(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
NOT_THIS_TYPE(fmi3GetNumberOfEventIndicators, size_t *n)
NOT_THIS_TYPE(fmi3GetNumberOfContinuousStates, size_t *n)
NOT_THIS_TYPE(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
