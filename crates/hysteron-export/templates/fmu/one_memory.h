/* Numbers of the variables; parameters follow. */
enum {
    FMU_TIME = 0,
    FMU_INPUT = 1,
    FMU_OUTPUT = 2,
    FMU_STATUS = 3,
    FMU_DISPLACEMENT = 4,
    FMU_REST_VOLTAGE = 5
};

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

