//! Identification of a force against a displacement: known answers from independent code, measured dampers.
#![allow(clippy::unwrap_used)] // A failure is a failed test.
#![allow(clippy::print_stdout)] // What is skipped is said.

mod measured;
mod recovery;

use hysteron_identify::IdentifyError;
use hysteron_identify::force::{Identification, Options};
use hysteron_model::record::InputOutput;

#[test]
fn the_quantities_call_for_a_kind() {
    use hysteron_identify::usual_kind;
    use hysteron_model::model_file::Kind;
    use hysteron_model::record::{TimeBase, Unit};
    let of = |u: &str, y: &str| {
        let mut data = InputOutput::new("r", TimeBase::uniform(1.0), vec![0.0, 1.0], vec![0.0, 1.0]).unwrap();
        (data.u_unit, data.y_unit) = (Unit::new(u), Unit::new(y));
        data
    };
    assert_eq!(usual_kind(&[of("um", "kN"), of("urad", "Nm")]), Kind::Force);
    assert_eq!(usual_kind(&[of("um", "N"), of("V", "N")]), Kind::Hammerstein);
    assert_eq!(usual_kind(&[of("N", "um")]), Kind::Hammerstein);
    assert_eq!(usual_kind(&[]), Kind::Hammerstein);
}

fn identify(records: &[InputOutput], options: &Options) -> Result<Identification, IdentifyError> {
    hysteron_identify::force::identify(records, options, &hysteron_identify::Watch::silent(), None)
}
