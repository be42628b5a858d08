/* Everything the compensator remembers. The caller's: static, on the stack, one for each device. Its members
   are nobody else's business. */
typedef struct {
    $name_real offset;       /* constant of the displacement */
    $name_real voltage;      /* last voltage */
    $name_real displacement; /* last displacement of the model */
    $name_real output;       /* last output of the hysteresis */
    $name_real slope;        /* and how steeply it rose there */
    $name_real reference;    /* last reference that was finite */
    $name_real ring[$NAME_REFERENCES]; /* newest references */
    unsigned ring_at;                      /* where the ring is written next */
