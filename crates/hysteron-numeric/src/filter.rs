//! A filter of which only every n-th output is computed.

/// Four outputs at a time, so that additions need not wait for one another.
#[inline(always)]
pub(super) fn filter_every_kernel(kernel: &[f64], step: usize, x: &[f64], out: &mut [f64]) {
    let taps = kernel.len();
    let mut at = 0;
    for out in out.chunks_mut(4) {
        // A last group of fewer repeats its last window.
        let windows: [Option<&[f64]>; 4] = std::array::from_fn(|i| {
            let first = at + i.min(out.len() - 1) * step;
            x.get(first..first + taps)
        });
        let [Some(a), Some(b), Some(c), Some(d)] = windows else { return };
        let mut sums = [[0.0; 8]; 4];
        let mut last = [0.0; 4];
        let eights = a.chunks_exact(8).zip(b.chunks_exact(8)).zip(c.chunks_exact(8).zip(d.chunks_exact(8)));
        for (h, ((a, b), (c, d))) in kernel.chunks_exact(8).zip(eights) {
            for (sum, x) in sums.iter_mut().zip([a, b, c, d]) {
                for i in 0..8 {
                    sum[i] += h[i] * x[i];
                }
            }
        }
        let rest = taps - taps % 8;
        for (last, x) in last.iter_mut().zip([a, b, c, d]) {
            *last = kernel[rest..].iter().zip(&x[rest..]).map(|(h, x)| h * x).sum();
        }
        for ((out, sums), last) in out.iter_mut().zip(&sums).zip(&last) {
            *out = sums.iter().sum::<f64>() + last;
        }
        at += 4 * step;
    }
}
