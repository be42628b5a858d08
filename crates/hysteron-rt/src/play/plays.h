//= sizes
//{ plays|sided|relaxing
#define $NAME_PLAYS $N_PLAYS
//}
//= members of the state
//{ plays|sided
    $name_real play[$NAME_PLAYS];
//}
//{ relaxing
    $name_real play[$NAME_PLAYS]; /* distances behind the voltage */
//}
//{ rate|relaxing
    bool rested; /* has not moved since it was virgin */
//}
//= parameters
//{ plays|sided
    $name_real weight[$NAME_PLAYS];
//}
