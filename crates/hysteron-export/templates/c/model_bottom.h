} $name_state;

//+ size of a saved state

/* Makes a state of any memory: at rest, and the hysteresis virgin, at 0 $INPUT_UNIT. Call this once,
   first. */
void $name_init($name_state *state);

/* Puts the model at rest, and the hysteresis virgin, at `voltage` [$INPUT_UNIT]: it has been so for ever.
   `displacement` [$OUTPUT_UNIT] is that there. */
$name_status $name_rest_at($name_state *state, $name_real voltage, $name_real *displacement);

/* As $name_rest_at, having been driven there, without turning, from the voltage `virgin` where the hysteresis
   was virgin. $NAME_OVERFLOW may leave it at rest at `virgin`. */
$name_status $name_rest_after($name_state *state, $name_real virgin, $name_real voltage,
                              $name_real *displacement);

/* As $name_rest_at, with the constant of the displacement chosen so that the displacement there is the one
   given: the first step has no jump. */
$name_status $name_start_at($name_state *state, $name_real voltage, $name_real displacement);

/* One sample: the displacement [$OUTPUT_UNIT] after a monotone move to `voltage` [$INPUT_UNIT] within one
   sample period. */
$name_status $name_step($name_state *state, $name_real voltage, $name_real *displacement);

/* Changes the trims, from the next step on. $NAME_NOT_FINITE for a number that is not finite, or a gain of
   0: they are then as they were. */
$name_status $name_trim($name_state *state, const $name_trims *trims);

//+ functions of a saved state
#ifdef __cplusplus
}
#endif

#endif
