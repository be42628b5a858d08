
/* Numbers of the variables. */
enum {
    FMU_TIME = 0,
    FMU_REFERENCE = 1,
    FMU_OUTPUT = 2,
    FMU_STATUS = 3,
    FMU_DISPLACEMENT = 4,
    FMU_REST_VOLTAGE = 5,
    FMU_OFFSET = 6,
    FMU_GAIN = 7,
    FMU_READING = 8
};

/* All that changes, and that a saved state holds. */
typedef struct {
    $name_state model;
    double reference, reading, output;
    double rest_voltage;
    $name_trims trims;
    double start, time; /* of the first sample, of the last communication point [s] */
    double samples;     /* taken since; whole, exact up to 2^53 */
    int32_t status;     /* of the last call of the controller */
    fmu_phase phase;
} fmu_memory;

