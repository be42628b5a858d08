//= sizes
//{ bouc_wen
#define $NAME_OPERATORS $N_OPERATORS
//}
//= members of the state
//{ bouc_wen
    $name_real z[$NAME_OPERATORS], z_carry[$NAME_OPERATORS];
//}
//= parameters
//{ bouc_wen
    $name_bouc_wen operators[$NAME_OPERATORS];
//}
