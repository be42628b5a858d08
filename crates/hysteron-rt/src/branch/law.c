//{ branch
//{ !own_output
/* Output of a state at u. */
static real branch_output(real y, real u)
{
    (void)u;
    return y;
}

//}
//{ !own_virgin
/* A state, virgin at u. */
static real branch_virgin(real u)
{
    (void)u;
    return R(0);
}

//}
//}
