//! FFT plans and array kernels.
