//= sizes
//{ states
#define $NAME_STATE_LAWS $N_STATE_LAWS
//}
//= members of the state
//{ states
    $name_real z[$NAME_STATE_LAWS], z_carry[$NAME_STATE_LAWS];
//}
//= parameters
//{ states
    $name_state_law state_laws[$NAME_STATE_LAWS];
//}
