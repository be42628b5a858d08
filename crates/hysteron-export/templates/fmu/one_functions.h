static $name_real *fmu_parameter($name_state *state, unsigned reference)
{
    switch (reference) {
$PARAMETER_CASES
    default:
        return NULL;
    }
}

static void fmu_clear(fmu_instance *fmu)
{
    memset(&fmu->now, 0, sizeof fmu->now);
    $name_init(&fmu->now.model);
//{ inverse
    fmu->now.rest_voltage = (double)fmu->now.model.voltage;
    fmu->now.input = (double)fmu->now.model.displacement;
    fmu->now.output = (double)fmu->now.model.voltage;
//}
//{ !inverse
    fmu->now.input = (double)fmu->now.model.voltage;
    fmu->now.output = (double)fmu->now.model.displacement;
//}
}

static fmu_instance *fmu_new(const char *name, const char *token)
{
    fmu_instance *fmu;
    if (token == NULL || strcmp(token, FMU_TOKEN) != 0) {
        return NULL;
    }
    fmu = calloc(1, sizeof *fmu);
    if (fmu != NULL) {
        if (name != NULL) {
            strncpy(fmu->name, name, sizeof fmu->name - 1);
        }
        fmu_clear(fmu);
    }
    return fmu;
}

static int fmu_fail(const fmu_instance *fmu, const char *message)
{
    if (fmu->log != NULL) {
        fmu->log(fmu->environment, fmu->name, message, 1);
    }
    return 0;
}

/* The functions below give 1, or 0 where they refuse. */

static int fmu_get(fmu_instance *fmu, unsigned reference, double *value)
{
    const $name_real *parameter = fmu_parameter(&fmu->now.model, reference);
    switch (reference) {
    case FMU_TIME:
        *value = fmu->now.time;
        return 1;
    case FMU_INPUT:
        *value = fmu->now.input;
        return 1;
    case FMU_OUTPUT:
        *value = fmu->now.output;
        return 1;
//{ inverse
    case FMU_DISPLACEMENT:
        *value = (double)fmu->now.model.displacement;
        return 1;
    case FMU_REST_VOLTAGE:
        *value = fmu->now.rest_voltage;
        return 1;
//}
    default:
        break;
    }
    if (parameter == NULL) {
        return fmu_fail(fmu, "no real variable has this value reference");
    }
    *value = (double)*parameter;
    return 1;
}

static int fmu_set(fmu_instance *fmu, unsigned reference, double value)
{
    $name_real *parameter = fmu_parameter(&fmu->now.model, reference);
    if (reference == FMU_INPUT) {
        /* Any number: what cannot be taken is refused by a step, and the variable status says so. */
        fmu->now.input = value;
        return 1;
    }
//{ inverse
    if (reference == FMU_REST_VOLTAGE) {
        fmu->now.rest_voltage = value;
        return 1;
    }
//}
    if (parameter == NULL) {
        return fmu_fail(fmu, "no input or parameter has this value reference");
    }
    if (!(value - value >= 0.0) || !(($name_real)value - ($name_real)value >= R(0))) {
        return fmu_fail(fmu, "a parameter must be finite");
    }
    *parameter = ($name_real)value;
    return 1;
}

/* At rest before the first sample. */
static int fmu_settle(fmu_instance *fmu)
{
    $name_real y;
//{ inverse
    fmu->now.status = (int32_t)$name_rest_at(&fmu->now.model, ($name_real)fmu->now.rest_voltage, &y);
    fmu->now.output = (double)fmu->now.model.voltage;
//}
//{ !inverse
    fmu->now.status = (int32_t)$name_rest_at(&fmu->now.model, ($name_real)fmu->now.input, &y);
    fmu->now.output = (double)y;
//}
    return fmu->now.status >= (int32_t)$NAME_OK
           || fmu_fail(fmu, "the model cannot rest at the voltage it is to start at");
}

static int fmu_step(fmu_instance *fmu, double time, double length)
{
    const double period = 1.0 / (double)$NAME_SAMPLE_RATE_HZ;
    double end;
    if (fmu->now.phase != FMU_STEPPING) {
        return fmu_fail(fmu, "a step before the initialization has ended, or after termination");
    }
    if (!(length >= 0.0) || !(time + length - (time + length) >= 0.0)) {
        return fmu_fail(fmu, "the length of a communication step must not be negative, and finite");
    }
    end = time + length - 1e-3 * period;
    while (fmu->now.start + fmu->now.samples * period < end) {
        $name_real y;
        fmu->now.status = (int32_t)$name_step(&fmu->now.model, ($name_real)fmu->now.input, &y);
        fmu->now.output = (double)y;
        fmu->now.samples += 1.0;
    }
    fmu->now.time = time + length;
    return 1;
}

