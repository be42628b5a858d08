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

/* Takes one sample. */
static void fmu_sample(fmu_instance *fmu)
{
    $name_real given[FMU_GIVEN], found[FMU_FOUND];
    int32_t k;
    for (k = 0; k < FMU_GIVEN; k++) {
        given[k] = ($name_real)fmu->now.input[k];
    }
    fmu->now.status = (int32_t)$name_step(&fmu->now.model, given, found);
    fmu_take(fmu);
}

