//{ moments
/* m_k(x), the integral of theta^k exp(-x (1 - theta)) from 0 to 1, x >= 0: a series of positive terms, far
   out the recurrence. */
static void moments(real x, int32_t count, real *m)
{
    const real decay = F(exp)(-x);
    real term = R(1);
    int32_t i, k;
    if (x > R(30)) {
        real last = (-decay + R(1)) / x;
        for (k = 0; k < count; k++) {
            if (k > 0) {
                last = (-(last * (real)k) + R(1)) / x;
            }
            m[k] = last;
        }
        return;
    }
    for (k = 0; k < count; k++) {
        m[k] = R(0);
    }
    for (i = 0; i < 200; i++) {
        for (k = 0; k < count; k++) {
            m[k] = m[k] + term * (R(1) / (real)(i + k + 1));
        }
        term = term * (x * (R(1) / (real)(i + 1)));
        if (F(fabs)(term) <= R(0.0625) * R(EPSILON) * m[count - 1]) {
            break;
        }
    }
    for (k = 0; k < count; k++) {
        m[k] = decay * m[k];
    }
}

//}
