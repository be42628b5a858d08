//{ plays
/* A play of half-width r after a monotone move of its input to u. */
static real play(real r, real state, real u)
{
    const real low = u - r, high = u + r;
    const real kept = state > high ? high : state;
    return kept < low ? low : kept;
}

//}
