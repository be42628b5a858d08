} $name_state;

//+ size of a saved state

/* Makes a state of any memory: at rest, and the hysteresis virgin, at the voltage within the limits that is
   next to 0. Call this once, first. */
void $name_init($name_state *state);

/* Puts the model at rest, and the hysteresis virgin, at `voltage` [$INPUT_UNIT], moved into the limits, and
   the reference where that is: it has been so for ever. `displacement` [$OUTPUT_UNIT] is that there. */
$name_status $name_rest_at($name_state *state, $name_real voltage, $name_real *displacement);

/* As $name_rest_at, having been driven there, without turning, from the voltage `virgin` where the hysteresis
   was virgin. $NAME_OVERFLOW may leave it at rest at `virgin`. */
$name_status $name_rest_after($name_state *state, $name_real virgin, $name_real voltage,
                              $name_real *displacement);

/* After $name_rest_at or $name_rest_after, chooses the constant of the displacement so that the displacement
   there is the one measured: switched on without a jump. */
$name_status $name_measured_at_rest($name_state *state, $name_real displacement);

/* Takes the newest of the reference without moving: what is known ahead when the first step is made, oldest
   first. */
$name_status $name_know($name_state *state, $name_real reference);

/* One sample: the voltage [$INPUT_UNIT] for the next period. `reference` [$OUTPUT_UNIT] is the newest known,
   $NAME_PREVIEW samples ahead. */
$name_status $name_step($name_state *state, $name_real reference, $name_real *voltage);

/* As $name_step, against a disturbance [$OUTPUT_UNIT]: the displacement of the stage less that of the model,
   as an observer has it. */
$name_status $name_step_against($name_state *state, $name_real reference, $name_real disturbance,
                                $name_real *voltage);

/* Changes the trims, from the next step on. $NAME_NOT_FINITE for a number that is not finite, or a gain of
   0: they are then as they were. */
$name_status $name_trim($name_state *state, const $name_trims *trims);

//+ functions of a saved state
#ifdef __cplusplus
}
#endif

#endif
