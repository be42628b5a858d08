//! Polynomial degrees tried, and why the one used was chosen.

use super::IdentificationReportData;
use crate::number::significant;
use crate::page::{Column, Table};
use hysteron_identify::{BIC_FALL, DegreeTried};
use hysteron_numeric::number::fixed;

/// One polynomial degree that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DegreeRow {
    /// Degree.
    pub degree: usize,
    /// RMSE of its fit \[objective unit\].
    pub rmse: f64,
    /// Bayesian information criterion of its fit.
    pub bic: f64,
    /// Whether it was chosen.
    pub chosen: bool,
}

/// The degrees tried, the chosen one shaded.
pub(super) fn table(data: &IdentificationReportData) -> Table {
    let columns = [
        Column::number("degree", ""),
        Column::number("RMSE", &data.objective_unit),
        Column::number("BIC", ""),
    ];
    let mut table = Table::new(columns).captioned("Polynomial degrees tried");
    if !data.degrees_note.is_empty() {
        table = table.note(&data.degrees_note);
    }
    table = table.note(format!(
        "From the lowest degree up, a higher one takes the place of the one chosen so far where it lowers BIC \
         by more than {BIC_FALL:.0} and its hysteresis is bounded; shaded: the one used. BIC counts only as \
         many samples as are independent."
    ));
    for d in &data.degrees {
        let cells = [d.degree.to_string(), significant(d.rmse, 4), fixed(d.bic, 1)];
        table = if d.chosen { table.highlighted_row(cells) } else { table.row(cells) };
    }
    table
}

/// What chose the degree `used`: BIC, an option that names a coefficient, or that a better one is not
/// bounded.
pub(super) fn reason(tried: &[DegreeTried], used: usize) -> String {
    let Some(own) = tried.iter().find(|d| d.degree == used) else { return String::new() };
    let (below, above): (Vec<&DegreeTried>, Vec<&DegreeTried>) =
        tried.iter().filter(|d| d.degree != used).partition(|d| d.degree < used);
    // Of those below, the one that BIC had chosen before.
    let mut before: Option<&DegreeTried> = None;
    for &d in &below {
        if before.is_none_or(|best| d.is_demanded || d.bic < best.bic - BIC_FALL) {
            before = Some(d);
        }
    }
    let fall = before.map(|d| d.bic - own.bic);
    let mut text = match (fall, before) {
        (Some(fall), Some(d)) if fall > BIC_FALL => {
            format!("Degree {used} is used: BIC is {} lower than of degree {}", fixed(fall, 1), d.degree)
        }
        (Some(_), Some(d)) if own.is_demanded => format!(
            "Degree {used} is used because the options name one of its coefficients; BIC alone would not take \
             it over degree {}",
            d.degree
        ),
        (Some(_), Some(d)) => format!(
            "Degree {used} is used because the hysteresis of the degrees below it is not bounded; BIC alone \
             would not take it over degree {}",
            d.degree
        ),
        _ => format!("Degree {used} is used"),
    };
    let better: Vec<&DegreeTried> = above.into_iter().filter(|d| d.bic < own.bic - BIC_FALL).collect();
    let higher = tried.iter().any(|d| d.degree > used);
    text += &match (&better[..], higher) {
        (_, false) => ", and no higher one was tried.".to_owned(),
        ([], _) => format!(", and no higher one lowers BIC by more than {BIC_FALL:.0}."),
        (better, _) => {
            let names: Vec<String> = better.iter().map(|d| d.degree.to_string()).collect();
            format!(
                "; degree {} lowers BIC by more than {BIC_FALL:.0}, but its hysteresis is not bounded.",
                names.join(" and ")
            )
        }
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tried(list: &[(f64, bool, bool)]) -> Vec<DegreeTried> {
        let of = |(i, &(bic, is_demanded, is_bounded))| DegreeTried {
            degree: i + 1,
            rmse: 0.1,
            bic,
            is_demanded,
            is_bounded,
        };
        list.iter().enumerate().map(of).collect()
    }

    #[test]
    fn the_sentence_says_which_rule_decided() {
        let by_bic = tried(&[(-40.3, false, true), (-64.0, false, true), (-60.7, false, true)]);
        assert_eq!(
            reason(&by_bic, 2),
            "Degree 2 is used: BIC is 23.7 lower than of degree 1, and no higher one lowers BIC by more than \
             10."
        );
        assert_eq!(
            reason(&tried(&[(0.0, false, true), (-3.0, false, true)]), 1),
            "Degree 1 is used, and no higher one lowers BIC by more than 10."
        );
        let demanded = tried(&[(0.0, true, true), (-20.0, true, true), (-15.0, true, true)]);
        assert_eq!(
            reason(&demanded, 3),
            "Degree 3 is used because the options name one of its coefficients; BIC alone would not take it \
             over degree 2, and no higher one was tried."
        );
        let unbounded = tried(&[(0.0, false, true), (-20.0, false, false)]);
        assert_eq!(
            reason(&unbounded, 1),
            "Degree 1 is used; degree 2 lowers BIC by more than 10, but its hysteresis is not bounded."
        );
        assert_eq!(
            reason(&tried(&[(0.0, false, true), (-54.8, false, true)]), 2),
            "Degree 2 is used: BIC is 54.8 lower than of degree 1, and no higher one was tried."
        );
        assert_eq!(reason(&[], 3), "");
    }
}
