//{ saves

/* What the bytes of a saved state begin with: "HYST", and the mark of this export. */
#define SAVED_MAGIC 0x54535948u
#define SAVED_MARK_LOW $MARK_LOW
#define SAVED_MARK_HIGH $MARK_HIGH

static uint32_t checksum(const uint8_t *bytes, uint32_t count)
{
    uint32_t crc = 0xFFFFFFFFu, k, bit;
    for (k = 0u; k < count; k++) {
        crc ^= bytes[k];
        for (bit = 0u; bit < 8u; bit++) {
            crc = (crc & 1u) != 0u ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
        }
    }
    return crc ^ 0xFFFFFFFFu;
}

static uint32_t put_whole(uint8_t *bytes, uint32_t at, uint32_t x)
{
    uint32_t k;
    for (k = 0u; k < 4u; k++) {
        bytes[at + k] = (uint8_t)((x >> (8u * k)) & 0xFFu);
    }
    return at + 4u;
}

static uint32_t whole_at(const uint8_t *bytes, uint32_t at)
{
    uint32_t x = 0u, k;
    for (k = 0u; k < 4u; k++) {
        x |= (uint32_t)bytes[at + k] << (8u * k);
    }
    return x;
}

static uint32_t put_reals(uint8_t *bytes, uint32_t at, const real *numbers, int32_t count)
{
    int32_t i;
    for (i = 0; i < count; i++) {
        $BITS bits;
        uint32_t k;
        (void)memcpy(&bits, &numbers[i], sizeof bits);
        for (k = 0u; k < sizeof bits; k++) {
            bytes[at] = (uint8_t)((bits >> (8u * k)) & 0xFFu);
            at++;
        }
    }
    return at;
}

static uint32_t take_reals(const uint8_t *bytes, uint32_t at, real *numbers, int32_t count)
{
    int32_t i;
    for (i = 0; i < count; i++) {
        $BITS bits = 0u;
        uint32_t k;
        for (k = 0u; k < sizeof bits; k++) {
            bits |= ($BITS)bytes[at] << (8u * k);
            at++;
        }
        (void)memcpy(&numbers[i], &bits, sizeof bits);
    }
    return at;
}

void $name_save(const $name_state *state, uint8_t bytes[$NAME_SAVED_BYTES])
{
    uint32_t at = 0u;
//{ saved_rows
    int32_t i;
//}
    at = put_whole(bytes, at, SAVED_MAGIC);
    at = put_whole(bytes, at, SAVED_MARK_LOW);
    at = put_whole(bytes, at, SAVED_MARK_HIGH);
$SAVE_MEMBERS
    (void)put_whole(bytes, at, checksum(bytes, at));
}

$name_status $name_restore($name_state *state, const uint8_t bytes[$NAME_SAVED_BYTES])
{
    const uint32_t end = (uint32_t)$NAME_SAVED_BYTES - 4u;
    uint32_t at = $SAVED_NUMBERS_AT;
//{ saved_rows
    int32_t i;
//}
    if (whole_at(bytes, 0u) != SAVED_MAGIC || whole_at(bytes, 4u) != SAVED_MARK_LOW
        || whole_at(bytes, 8u) != SAVED_MARK_HIGH || whole_at(bytes, end) != checksum(bytes, end)) {
        return $NAME_NOT_SAVED;
    }
$CHECK_MEMBERS
$RESTORE_MEMBERS
    (void)at;
    return $NAME_OK;
}
//}
