//= sizes
//{ branch
#define $NAME_STATES $N_STATES
//}
//= members of the state
//{ branch
    $name_real y[$NAME_STATES], y_carry[$NAME_STATES];
//}
//= parameters
//{ branch
    $name_real weight[$NAME_STATES];
//}
