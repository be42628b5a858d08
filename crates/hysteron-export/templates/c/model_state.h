/* Everything the model remembers. The caller's: static, on the stack, one for each device. Its members are
   nobody else's business. */
typedef struct {
    $name_real offset;       /* constant of the displacement */
    $name_real voltage;      /* last voltage */
    $name_real displacement; /* last displacement */
