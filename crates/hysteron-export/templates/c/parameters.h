//{ tunable

//{ bouc_wen
/* A Bouc-Wen operator. */
typedef struct {
    $name_real alpha, beta, gamma, n;
} $name_bouc_wen;

//}
/* The numbers of the hysteresis, which may be changed while the model runs. */
typedef struct {
//{ polynomial
    $name_real polynomial[$N_POLYNOMIAL];
//}
//+ parameters
} $name_parameters;
//}

