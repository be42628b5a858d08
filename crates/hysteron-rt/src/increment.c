//{ accumulates
/* x + delta without losing what is smaller than half a unit of x (W. Kahan 1965,
   doi:10.1145/363707.363723). */
static void accumulate(real *x, real *carry, real delta)
{
    const real more = delta + *carry;
    const real sum = *x + more;
    *carry = more - (sum - *x);
    *x = sum;
}

//}
