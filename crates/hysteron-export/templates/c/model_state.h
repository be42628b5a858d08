/* Trims, for the field: displacement = offset + gain * what the model gives. */
typedef struct {
    $name_real gain;   /* 1 at first */
    $name_real offset; /* constant of the displacement [$OUTPUT_UNIT] */
} $name_trims;

/* Everything the model remembers. The caller's: static, on the stack, one for each device. Its members are
   nobody else's business. */
typedef struct {
    $name_trims trims;       /* $name_trim sets them */
    $name_real voltage;      /* last voltage */
    $name_real displacement; /* last displacement */
