static void fmu_clear(fmu_instance *fmu)
{
    memset(&fmu->now, 0, sizeof fmu->now);
    $name_init(&fmu->now.model);
    fmu->now.trims = fmu->now.model.inverse.trims;
    fmu->now.output = (double)fmu->now.model.inverse.voltage;
    fmu->now.rest_voltage = fmu->now.output;
    fmu->now.reference = (double)fmu->now.model.inverse.displacement;
    fmu->now.reading = fmu->now.reference;
}

static int fmu_get(fmu_instance *fmu, unsigned reference, double *value)
{
    switch (reference) {
    case FMU_TIME:
        *value = fmu->now.time;
        return 1;
    case FMU_REFERENCE:
        *value = fmu->now.reference;
        return 1;
    case FMU_OUTPUT:
        *value = fmu->now.output;
        return 1;
    case FMU_DISPLACEMENT:
        *value = (double)fmu->now.model.inverse.displacement;
        return 1;
    case FMU_REST_VOLTAGE:
        *value = fmu->now.rest_voltage;
        return 1;
    case FMU_READING:
        *value = fmu->now.reading;
        return 1;
    case FMU_GAIN:
        *value = (double)fmu->now.trims.gain;
        return 1;
    case FMU_OFFSET:
        *value = (double)fmu->now.trims.offset;
        return 1;
    default:
        return fmu_fail(fmu, "no real variable has this value reference");
    }
}

/* Inputs are any number: what cannot be taken is refused by a step, and the variable status says so. */
static int fmu_set(fmu_instance *fmu, unsigned reference, double value)
{
    $name_trims trims = fmu->now.trims;
    switch (reference) {
    case FMU_REFERENCE:
        fmu->now.reference = value;
        return 1;
    case FMU_READING:
        fmu->now.reading = value;
        return 1;
    case FMU_REST_VOLTAGE:
        fmu->now.rest_voltage = value;
        return 1;
    case FMU_GAIN:
        trims.gain = ($name_real)value;
        break;
    case FMU_OFFSET:
        trims.offset = ($name_real)value;
        break;
    default:
        return fmu_fail(fmu, "no input or parameter has this value reference");
    }
    if ($name_trim(&fmu->now.model, &trims) < $NAME_OK) {
        return fmu_fail(fmu, "a parameter must be finite, and the gain not 0");
    }
    fmu->now.trims = trims;
    return 1;
}

/* At rest before the first sample, with this reading. */
static int fmu_settle(fmu_instance *fmu)
{
    const $name_real rest = ($name_real)fmu->now.rest_voltage;
    $name_real y;
    fmu->now.status =
        (int32_t)$name_rest_after(&fmu->now.model, rest, rest, ($name_real)fmu->now.reading, &y);
    fmu->now.output = (double)fmu->now.model.inverse.voltage;
    return fmu->now.status >= (int32_t)$NAME_OK
           || fmu_fail(fmu, "the controller cannot rest at the voltage it is to start at, with this reading");
}

/* Takes one sample: the reading at its beginning, then the reference for the next, whose voltage it puts
   out. */
static void fmu_sample(fmu_instance *fmu)
{
    const bool read = $name_measured(&fmu->now.model, ($name_real)fmu->now.reading) >= $NAME_OK;
    $name_real u;
    fmu->now.status = (int32_t)$name_step(&fmu->now.model, ($name_real)fmu->now.reference, &u);
    if (!read) {
        fmu->now.status = (int32_t)$NAME_NOT_FINITE;
    }
    fmu->now.output = (double)u;
}

