/* What is put out. */
static void fmu_take(fmu_instance *fmu)
{
    int32_t k;
    for (k = 0; k < FMU_FOUND; k++) {
//{ inverse
        fmu->now.output[k] = (double)fmu->now.model.held[k];
//}
//{ !inverse
        fmu->now.output[k] = (double)fmu->now.model.output[k];
//}
    }
}

static void fmu_clear(fmu_instance *fmu)
{
    int32_t k;
    memset(&fmu->now, 0, sizeof fmu->now);
    $name_init(&fmu->now.model);
    fmu_take(fmu);
    for (k = 0; k < FMU_GIVEN; k++) {
//{ inverse
        fmu->now.input[k] = (double)fmu->now.model.output[k];
//}
//{ !inverse
        fmu->now.input[k] = (double)fmu->now.model.held[k];
//}
    }
//{ inverse
    for (k = 0; k < FMU_FOUND; k++) {
        fmu->now.rest_voltage[k] = fmu->now.output[k];
    }
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

/* The place of a number that may be set; NULL for others. */
static double *fmu_given(fmu_instance *fmu, unsigned reference)
{
    if (reference >= FMU_INPUT && reference < FMU_INPUT + FMU_GIVEN) {
        return &fmu->now.input[reference - FMU_INPUT];
    }
//{ inverse
    if (reference >= FMU_REST_VOLTAGE && reference < FMU_REST_VOLTAGE + FMU_FOUND) {
        return &fmu->now.rest_voltage[reference - FMU_REST_VOLTAGE];
    }
//}
    return NULL;
}

static int fmu_get(fmu_instance *fmu, unsigned reference, double *value)
{
    const double *given = fmu_given(fmu, reference);
    if (given != NULL) {
        *value = *given;
    } else if (reference == FMU_TIME) {
        *value = fmu->now.time;
    } else if (reference >= FMU_OUTPUT && reference < FMU_OUTPUT + FMU_FOUND) {
        *value = fmu->now.output[reference - FMU_OUTPUT];
    } else {
        return fmu_fail(fmu, "no real variable has this value reference");
    }
    return 1;
}

/* Any number: what cannot be taken is refused by a step, and the variable status says so. */
static int fmu_set(fmu_instance *fmu, unsigned reference, double value)
{
    double *given = fmu_given(fmu, reference);
    if (given == NULL) {
        return fmu_fail(fmu, "no input or parameter has this value reference");
    }
    *given = value;
    return 1;
}

/* At rest before the first sample. */
static int fmu_settle(fmu_instance *fmu)
{
    int32_t k;
//{ inverse
    $name_real u[FMU_FOUND], y[FMU_GIVEN];
    for (k = 0; k < FMU_FOUND; k++) {
        u[k] = ($name_real)fmu->now.rest_voltage[k];
    }
    fmu->now.status = (int32_t)$name_rest_at(&fmu->now.model, u, y);
//}
//{ !inverse
    $name_real u[FMU_GIVEN];
    for (k = 0; k < FMU_GIVEN; k++) {
        u[k] = ($name_real)fmu->now.input[k];
    }
    fmu->now.status = (int32_t)$name_rest_at(&fmu->now.model, u);
//}
    fmu_take(fmu);
    return fmu->now.status >= (int32_t)$NAME_OK
           || fmu_fail(fmu, "the model cannot rest at the voltages it is to start at");
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
        $name_real given[FMU_GIVEN], found[FMU_FOUND];
        int32_t k;
        for (k = 0; k < FMU_GIVEN; k++) {
            given[k] = ($name_real)fmu->now.input[k];
        }
        fmu->now.status = (int32_t)$name_step(&fmu->now.model, given, found);
        fmu_take(fmu);
        fmu->now.samples += 1.0;
    }
    fmu->now.time = time + length;
    return 1;
}

