//! Points that are not finite break a curve.

pub(super) fn finite(point: (f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

pub(super) fn push_break(out: &mut Vec<(f64, f64)>) {
    if out.last().is_some_and(|p| finite(*p)) {
        out.push((f64::NAN, f64::NAN));
    }
}

pub(super) fn trim_break(out: &mut Vec<(f64, f64)>) {
    if out.last().is_some_and(|p| !finite(*p)) {
        out.pop();
    }
}
