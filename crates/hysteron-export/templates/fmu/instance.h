/* What an instance of the FMU holds and does, the same for every version of the interface. Written by
 * hysteron export.
 *
 * Sample k is taken at the time start + k/rate with the input set before the communication step that begins
 * at or before it; a communication step from t to t + H takes all samples with t <= time < t + H, so that
 * the output at t + H is that of the last of them. */
#ifndef FMU_INSTANCE_H
#define FMU_INSTANCE_H

#include <stdlib.h>
#include <string.h>

#include "$name.h"

#if defined(_WIN32)
#define FMU_EXPORT __declspec(dllexport)
#else
#define FMU_EXPORT __attribute__((visibility("default")))
#endif

#define FMU_TOKEN "$TOKEN"

/* Numbers of the variables; parameters follow. */
enum {
    FMU_TIME = 0,
    FMU_INPUT = 1,
    FMU_OUTPUT = 2,
    FMU_STATUS = 3,
    FMU_DISPLACEMENT = 4,
    FMU_REST_VOLTAGE = 5
};

typedef enum { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_STEPPING, FMU_TERMINATED } fmu_phase;

/* All that changes, and that a saved state holds. */
typedef struct {
    $name_state model;
    double input, output;
//{ inverse
    double rest_voltage;
//}
    double start, time; /* of the first sample, of the last communication point [s] */
    double samples;     /* taken since; whole, exact up to 2^53 */
    int32_t status;     /* of the last call of the model */
    fmu_phase phase;
} fmu_memory;

typedef struct {
    fmu_memory now;
    void *environment;
    void (*log)(void *environment, const char *name, const char *message, int is_error);
    void *log_function; /* where the version's logger is kept */
    char name[64];
} fmu_instance;

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

/* Everything begins at this time. */
static void fmu_begin(fmu_instance *fmu, double start)
{
    fmu->now.start = start;
    fmu->now.time = start;
}

static int fmu_enter(fmu_instance *fmu, fmu_phase phase)
{
    fmu->now.phase = phase;
    return fmu_settle(fmu);
}

/* All of them, whatever becomes of one. During initialization what is put out follows what is put in. */
static int fmu_get_all(fmu_instance *fmu, const unsigned references[], size_t n, double values[])
{
    size_t k;
    int holds = 1;
    if (fmu->now.phase == FMU_INITIALIZING && n > 0) {
        (void)fmu_settle(fmu);
    }
    for (k = 0; k < n; k++) {
        holds = fmu_get(fmu, references[k], &values[k]) && holds;
    }
    return holds;
}

static int fmu_set_all(fmu_instance *fmu, const unsigned references[], size_t n, const double values[])
{
    size_t k;
    int holds = 1;
    for (k = 0; k < n; k++) {
        holds = fmu_set(fmu, references[k], values[k]) && holds;
    }
    return holds;
}

/* The status is the only whole number. */
static int fmu_get_status(const fmu_instance *fmu, const unsigned references[], size_t n, int values[])
{
    size_t k;
    for (k = 0; k < n; k++) {
        if (references[k] != FMU_STATUS) {
            return fmu_fail(fmu, "no integer variable has this value reference");
        }
        values[k] = fmu->now.status;
    }
    return 1;
}

/* Saved states: *place is freed and filled anew. */
static int fmu_save(const fmu_memory *now, void **place)
{
    fmu_memory *saved = malloc(sizeof *saved);
    if (saved != NULL) {
        *saved = *now;
    }
    free(*place);
    *place = saved;
    return saved != NULL;
}

static int fmu_restore(fmu_instance *fmu, const void *saved)
{
    if (saved == NULL) {
        return fmu_fail(fmu, "no saved state");
    }
    fmu->now = *(const fmu_memory *)saved;
    return 1;
}

/* A saved state as bytes: the memory, and the CRC-32 of this unit's token and the memory. */
#define FMU_SAVED_BYTES (sizeof(fmu_memory) + sizeof(uint32_t))

static uint32_t fmu_checksum_from(uint32_t crc, const unsigned char *bytes, size_t n)
{
    size_t k;
    int bit;
    for (k = 0; k < n; k++) {
        crc ^= bytes[k];
        for (bit = 0; bit < 8; bit++) {
            crc = (crc & 1u) != 0u ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
        }
    }
    return crc;
}

static uint32_t fmu_checksum(const unsigned char *memory)
{
    const unsigned char *text = (const unsigned char *)FMU_TOKEN;
    const uint32_t token = fmu_checksum_from(0xFFFFFFFFu, text, strlen(FMU_TOKEN));
    return ~fmu_checksum_from(token, memory, sizeof(fmu_memory));
}

static int fmu_write(const fmu_instance *fmu, const void *saved, void *bytes, size_t size)
{
    uint32_t crc;
    if (saved == NULL || size < FMU_SAVED_BYTES) {
        return fmu_fail(fmu, "no saved state, or too little room for it");
    }
    memcpy(bytes, saved, sizeof(fmu_memory));
    crc = fmu_checksum(bytes);
    memcpy((unsigned char *)bytes + sizeof(fmu_memory), &crc, sizeof crc);
    return 1;
}

static int fmu_read(const fmu_instance *fmu, const void *bytes, size_t size, void **place)
{
    fmu_memory memory;
    uint32_t crc = 0;
    if (size == FMU_SAVED_BYTES) {
        memcpy(&crc, (const unsigned char *)bytes + sizeof memory, sizeof crc);
    }
    if (size != FMU_SAVED_BYTES || crc != fmu_checksum(bytes)) {
        return fmu_fail(fmu, "these bytes are no saved state of this model, or damaged");
    }
    memcpy(&memory, bytes, sizeof memory);
    return fmu_save(&memory, place);
}

#endif
