//{ linear_law
/* z after a move by du that passes through 0: there dz/d|u| = s alpha - kappa z changes its kappa. */
static real move_through_zero(const state_law *p, real z, real du)
{
    const bool down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du;
    const real lead = z == R(0) ? rise : z;
    const real kappa = lead < R(0) ? p->beta - turn : p->beta + turn;
    real decay, reach, end, rest, ignored;
    reach = relaxation(kappa, distance, &decay);
    end = z * decay + rise * reach;
    if (z == R(0) || (end < R(0)) == (z < R(0)) || rise == R(0)) {
        return end;
    }
    rest = distance - log_distance(kappa, -(z / rise));
    if (rest <= R(0)) {
        return rise * rest;
    }
    return rise * relaxation(p->alpha < R(0) ? p->beta - p->gamma : p->beta + p->gamma, rest, &ignored);
}

/* What a monotone move by du changes z by, without the cancellation of a difference:
   dz = (s alpha - kappa z) (1 - exp(-kappa |du|))/kappa, kappa = beta + s gamma sign z. */
static real increment(const state_law *p, real z, real du)
{
    const bool down = du < R(0);
    const real rise = down ? -p->alpha : p->alpha;
    const real turn = down ? -p->gamma : p->gamma;
    const real distance = down ? -du : du;
    const real lead = z == R(0) ? rise : z;
    const real kappa = lead < R(0) ? p->beta - turn : p->beta + turn;
    real ignored;
    const real reach = relaxation(kappa, distance, &ignored);
    const real change = (rise - kappa * z) * reach;
    const real end = z + change;
    if ((end < R(0) && z > R(0)) || (end > R(0) && z < R(0))) {
        return move_through_zero(p, z, du) - z;
    }
    return change;
}

//}
