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

/* Takes one sample. */
static void fmu_sample(fmu_instance *fmu)
{
    $name_real y;
    fmu->now.status = (int32_t)$name_step(&fmu->now.model, ($name_real)fmu->now.input, &y);
    fmu->now.output = (double)y;
}

