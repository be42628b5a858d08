//{ !inverse
#define FMU_GIVEN $NAME_INPUTS
#define FMU_FOUND $NAME_OUTPUTS
//}
//{ inverse
#define FMU_GIVEN $NAME_OUTPUTS
#define FMU_FOUND $NAME_INPUTS
//}

/* Numbers of the variables: each list one after the other. */
enum {
    FMU_TIME = 0,
    FMU_INPUT = 1,
    FMU_OUTPUT = FMU_INPUT + FMU_GIVEN,
    FMU_STATUS = FMU_OUTPUT + FMU_FOUND,
    FMU_REST_VOLTAGE = FMU_STATUS + 1
};

/* All that changes, and that a saved state holds. */
typedef struct {
    $name_state model;
    double input[FMU_GIVEN], output[FMU_FOUND];
//{ inverse
    double rest_voltage[FMU_FOUND];
//}
    double start, time; /* of the first sample, of the last communication point [s] */
    double samples;     /* taken since; whole, exact up to 2^53 */
    int32_t status;     /* of the last call of the model */
    fmu_phase phase;
} fmu_memory;

