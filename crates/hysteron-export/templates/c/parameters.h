//{ tunable

//{ states
//+ type of a state
//}
/* The numbers of the hysteresis, which may be changed while the model runs. */
typedef struct {
//{ polynomial
    $name_real polynomial[$N_POLYNOMIAL];
//}
//+ parameters
} $name_parameters;
//}

