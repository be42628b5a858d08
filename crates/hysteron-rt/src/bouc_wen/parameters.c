/* Parameters of a state, dz/du = alpha - beta s z |z|^(n-1) - gamma |z|^n, s = sign du. */
typedef struct {
    $name_real alpha, beta, gamma, n;
} $name_state_law;

