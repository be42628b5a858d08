//{ saves
/* Writes the state into `bytes`, which outlast a reset. A state that $name_restore makes of them goes on with
   the same bits. */
void $name_save(const $name_state *state, uint8_t bytes[$NAME_SAVED_BYTES]);

/* The state that was saved; in place of $name_init. $NAME_NOT_SAVED for any other bytes: the state is then as
   it was. */
$name_status $name_restore($name_state *state, const uint8_t bytes[$NAME_SAVED_BYTES]);

//}
