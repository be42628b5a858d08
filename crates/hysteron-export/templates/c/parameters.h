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
//{ bouc_wen
    $name_bouc_wen operators[$NAME_OPERATORS];
//}
//{ plays|sided
    $name_real weight[$NAME_PLAYS];
//}
//{ branch
    $name_real weight[$NAME_STATES];
//}
} $name_parameters;
//}

