//= sizes
//{ plane
/* Turning points that are remembered at once. */
#define $NAME_TURNS $N_TURNS
//}
//= members of the state
//{ plane
    /* Of the loops that are open, the widest first. */
    $name_real turn_voltage[$NAME_TURNS], turn_output[$NAME_TURNS];
    $name_real virgin, plane_virgin; /* where the relays were virgin, and what they put out there */
    $name_real plane;                /* what they put out now */
    int32_t kept;       /* below $NAME_TURNS + 1: turns */
    bool moved, rising; /* whether there has been a move, and upwards */
//}
