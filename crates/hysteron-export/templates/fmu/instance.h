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

typedef enum { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_STEPPING, FMU_TERMINATED } fmu_phase;

//+ memory of a unit
typedef struct {
    fmu_memory now;
    void *environment;
    void (*log)(void *environment, const char *name, const char *message, int is_error);
    void *log_function; /* where the version's logger is kept */
    char name[64];
} fmu_instance;

static int fmu_fail(const fmu_instance *fmu, const char *message)
{
    if (fmu->log != NULL) {
        fmu->log(fmu->environment, fmu->name, message, 1);
    }
    return 0;
}

/* The functions below give 1, or 0 where they refuse. */

//+ functions of a unit
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
        fmu_sample(fmu);
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
