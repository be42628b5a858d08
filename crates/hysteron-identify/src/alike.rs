//! Consistency of multi-axis records that one model is fitted to.

use super::IdentifyError;
use hysteron_model::axes::AxesRecord;

/// Channels, rate and units must agree.
pub(crate) fn same(first: &AxesRecord, records: &[AxesRecord]) -> Result<(), IdentifyError> {
    for other in records {
        let differ = |what, of_first: String, of_other: String| {
            if of_first == of_other {
                return Ok(());
            }
            Err(IdentifyError::Different {
                first: first.name.clone(),
                other: other.name.clone(),
                what,
                of_first,
                of_other,
            })
        };
        differ("number of inputs", first.u.len().to_string(), other.u.len().to_string())?;
        differ("number of outputs", first.y.len().to_string(), other.y.len().to_string())?;
        if (first.sample_rate_hz / other.sample_rate_hz).ln().abs() > 1e-6 {
            let rate = |record: &AxesRecord| format!("{:.4} Hz", record.sample_rate_hz);
            differ("sample rates", rate(first), rate(other))?;
        }
        differ("input units", first.u_unit.to_string(), other.u_unit.to_string())?;
        differ("output units", first.y_unit.to_string(), other.y_unit.to_string())?;
    }
    Ok(())
}
