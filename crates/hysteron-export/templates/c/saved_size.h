//{ saves
/* A saved state: the bytes "HYST"; 8 that mark this export (of another model, rate, number type or version
   they are others); whole numbers of 4 bytes; numbers, as IEEE 754 has them; the CRC-32 (IEEE 802.3) of all
   before it. Each has its lowest byte first. */
#define $NAME_SAVED_BYTES ($SAVED_BYTES)

//}
