//{ roots
/* A function that rises from one place to another, with what it depends on. */
typedef struct rising_function {
    real (*at)(const struct rising_function *f, real x, real *slope);
    real number[5];
} rising_function;

/* Its zero: Newton's method, a halving where a step leaves the bracket. */
static real rising_root(const rising_function *f, real low, real high, real start)
{
    real x = start < low ? low : start;
    int32_t count;
    x = x > high ? high : x;
    for (count = 0; count < 80; count++) {
        real slope, newton, next;
        const real value = f->at(f, x, &slope);
        if (value == R(0)) {
            return x;
        }
        if (value > R(0)) {
            high = x;
        } else {
            low = x;
        }
        newton = x - value / slope;
        next = low < newton && newton < high ? newton : R(0.5) * (low + high);
        if (F(fabs)(next - x) <= R(2) * R(EPSILON) * F(fabs)(x) || next <= low || next >= high) {
            return next;
        }
        x = next;
    }
    return x;
}

//}
