//{ tunable
    $name_parameters parameters;
//}
//{ bouc_wen
    $name_real z[$NAME_OPERATORS], z_carry[$NAME_OPERATORS];
//}
//{ branch
    $name_real y[$NAME_STATES], y_carry[$NAME_STATES];
//}
//{ plays
    $name_real play[$NAME_PLAYS];
//}
//{ sided
    $name_real play[$NAME_PLAYS];
//}
//{ activated
    $name_real play[$NAME_PLAYS]; /* distances behind the voltage */
//}
//{ rate|activated
    int rested; /* has not moved since it was virgin */
//}
//{ plane
    $name_real turn_voltage[$NAME_TURNS], turn_output[$NAME_TURNS]; /* of the loops that are open, the widest first */
    $name_real virgin, plane_virgin; /* where the relays were virgin, and what they put out there */
    $name_real plane;                /* what they put out now */
    int kept, moved, rising;             /* turns; whether there has been a move, and upwards */
//}
//{ means
    $name_real last_v; /* output of the hysteresis at the last voltage */
//}
    $name_real rest;                     /* what the dynamics have rested at */
    $name_real recent[$NAME_TAPS + 1]; /* newest inputs of the dynamics, the newest first */
//{ real_poles
    $name_real real_x[$NAME_REAL_POLES], real_carry[$NAME_REAL_POLES];
//}
//{ pairs
    $name_real pair_x[$NAME_PAIRS][2], pair_carry[$NAME_PAIRS][2];
//}
//{ delay
    $name_real delayed[$NAME_DELAY]; /* a ring */
    unsigned at;                         /* where it is written next */
//}
