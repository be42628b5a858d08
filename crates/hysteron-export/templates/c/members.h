//{ tunable
    $name_parameters parameters;
//}
//+ members of the state
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
    uint32_t at;                     /* below $NAME_DELAY: where it is written next */
//}
