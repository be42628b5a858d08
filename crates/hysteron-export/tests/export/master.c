/* A small master: loads the binary of an FMU, sets the inputs of every sample read from standard input
   (GIVEN doubles each), saves the state half-way as bytes and goes on from them, and writes the outputs of
   every sample, FOUND of them, to standard output. Arguments: the library, the token. Compiled with FMI=2 or
   3. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#include <windows.h>
#define LOAD(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define LOAD(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

#define MOST 4096
#if !defined(GIVEN)
#define GIVEN 1
#define FOUND 1
#endif
#define WANTED(holds) if (!(holds)) { fprintf(stderr, "line %d\n", __LINE__); return 1; }
#define FUNCTION(type, name, arguments)                       \
    type(*name) arguments;                                    \
    *(void **)&name = FIND(library, #name);                   \
    WANTED(name != NULL)

static double inputs[MOST][GIVEN];

int main(int count, char **arguments)
{
    const double period = 1.0 / RATE_HZ;
    unsigned input[GIVEN], output[FOUND];
    void *library, *unit, *saved = NULL;
    size_t n, k, size = 0;
    char *bytes;
#if defined(_WIN32)
    (void)_setmode(0, _O_BINARY);
    (void)_setmode(1, _O_BINARY);
#endif
    WANTED(count == 3);
    for (k = 0; k < GIVEN; k++) {
        input[k] = (unsigned)(k + 1);
    }
    for (k = 0; k < FOUND; k++) {
        output[k] = (unsigned)(GIVEN + k + 1);
    }
    n = fread(inputs, sizeof inputs[0], MOST, stdin);
    library = LOAD(arguments[1]);
    WANTED(library != NULL && n > 1);
#if FMI == 2
    FUNCTION(void *, fmi2Instantiate,
             (const char *, int, const char *, const char *, const void *, int, int))
    FUNCTION(int, fmi2SetupExperiment, (void *, int, double, double, int, double))
    FUNCTION(int, fmi2EnterInitializationMode, (void *))
    FUNCTION(int, fmi2ExitInitializationMode, (void *))
    FUNCTION(int, fmi2SetReal, (void *, const unsigned *, size_t, const double *))
    FUNCTION(int, fmi2GetReal, (void *, const unsigned *, size_t, double *))
    FUNCTION(int, fmi2DoStep, (void *, double, double, int))
    FUNCTION(int, fmi2GetFMUstate, (void *, void **))
    FUNCTION(int, fmi2SetFMUstate, (void *, void *))
    FUNCTION(int, fmi2FreeFMUstate, (void *, void **))
    FUNCTION(int, fmi2SerializedFMUstateSize, (void *, void *, size_t *))
    FUNCTION(int, fmi2SerializeFMUstate, (void *, void *, char *, size_t))
    FUNCTION(int, fmi2DeSerializeFMUstate, (void *, const char *, size_t, void **))
    FUNCTION(void, fmi2FreeInstance, (void *))
#define SET(x) fmi2SetReal(unit, input, GIVEN, x)
#define GET(x) fmi2GetReal(unit, output, FOUND, x)
#define STEP(t) fmi2DoStep(unit, t, period, 0)
    unit = fmi2Instantiate("unit", 1, arguments[2], NULL, NULL, 0, 0);
    WANTED(unit != NULL);
    WANTED(fmi2SetupExperiment(unit, 0, 0.0, 0.0, 0, 0.0) == 0 && SET(inputs[0]) == 0);
    WANTED(fmi2EnterInitializationMode(unit) == 0 && fmi2ExitInitializationMode(unit) == 0);
#else
    FUNCTION(void *, fmi3InstantiateCoSimulation,
             (const char *, const char *, const char *, _Bool, _Bool, _Bool, _Bool, const unsigned *, size_t,
              void *, void *, void *))
    FUNCTION(int, fmi3EnterInitializationMode, (void *, _Bool, double, double, _Bool, double))
    FUNCTION(int, fmi3ExitInitializationMode, (void *))
    FUNCTION(int, fmi3SetFloat64, (void *, const unsigned *, size_t, const double *, size_t))
    FUNCTION(int, fmi3GetFloat64, (void *, const unsigned *, size_t, double *, size_t))
    FUNCTION(int, fmi3DoStep, (void *, double, double, _Bool, _Bool *, _Bool *, _Bool *, double *))
    FUNCTION(int, fmi3GetFMUState, (void *, void **))
    FUNCTION(int, fmi3SetFMUState, (void *, void *))
    FUNCTION(int, fmi3FreeFMUState, (void *, void **))
    FUNCTION(int, fmi3SerializedFMUStateSize, (void *, void *, size_t *))
    FUNCTION(int, fmi3SerializeFMUState, (void *, void *, char *, size_t))
    FUNCTION(int, fmi3DeserializeFMUState, (void *, const char *, size_t, void **))
    FUNCTION(void, fmi3FreeInstance, (void *))
    _Bool event, ended, early;
    double last;
#define SET(x) fmi3SetFloat64(unit, input, GIVEN, x, GIVEN)
#define GET(x) fmi3GetFloat64(unit, output, FOUND, x, FOUND)
#define STEP(t) fmi3DoStep(unit, t, period, 0, &event, &ended, &early, &last)
#define fmi2GetFMUstate fmi3GetFMUState
#define fmi2SetFMUstate fmi3SetFMUState
#define fmi2FreeFMUstate fmi3FreeFMUState
#define fmi2SerializedFMUstateSize fmi3SerializedFMUStateSize
#define fmi2SerializeFMUstate fmi3SerializeFMUState
#define fmi2DeSerializeFMUstate fmi3DeserializeFMUState
#define fmi2FreeInstance fmi3FreeInstance
    unit = fmi3InstantiateCoSimulation("unit", arguments[2], NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    WANTED(unit != NULL && SET(inputs[0]) == 0);
    WANTED(fmi3EnterInitializationMode(unit, 0, 0.0, 0.0, 0, 0.0) == 0);
    WANTED(fmi3ExitInitializationMode(unit) == 0);
#endif
    for (k = 0; k < n; k++) {
        double result[FOUND];
        WANTED(SET(inputs[k]) == 0 && STEP((double)k * period) == 0 && GET(result) == 0);
        WANTED(fwrite(result, sizeof result, 1, stdout) == 1);
        if (k == n / 2) {
            WANTED(fmi2GetFMUstate(unit, &saved) == 0);
            WANTED(fmi2SerializedFMUstateSize(unit, saved, &size) == 0);
            bytes = malloc(size);
            WANTED(bytes != NULL && fmi2SerializeFMUstate(unit, saved, bytes, size) == 0);
            WANTED(fmi2FreeFMUstate(unit, &saved) == 0 && saved == NULL);
            bytes[size / 2] = (char)(bytes[size / 2] ^ 1);
            WANTED(fmi2DeSerializeFMUstate(unit, bytes, size, &saved) != 0);
            bytes[size / 2] = (char)(bytes[size / 2] ^ 1);
            WANTED(fmi2DeSerializeFMUstate(unit, bytes, size, &saved) == 0);
            WANTED(fmi2SetFMUstate(unit, saved) == 0 && fmi2FreeFMUstate(unit, &saved) == 0);
            free(bytes);
        }
    }
    fmi2FreeInstance(unit);
    return 0;
}
