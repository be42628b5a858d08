//! The list of families. A new one is a line here, its own file, and the law of its moves in `hysteron-rt`.

use super::family::{ColumnOperators, FamilyForm};
use super::{
    activated_plays, dahl, dead_zone_plays, duhem, generalised_play, jiles_atherton,
    krasnoselskii_pokrovskii, maxwell_slip, non_symmetric_bouc_wen, one_sided_plays, parallel_bouc_wen,
    preisach, rate_dependent_plays, song_der_kiureghian,
};

/// In the order in which they are listed to users.
static FAMILIES: [&dyn ColumnOperators; 15] = [
    &parallel_bouc_wen::Entry,
    &non_symmetric_bouc_wen::Entry,
    &song_der_kiureghian::Entry,
    &dahl::Entry,
    &duhem::Entry,
    &maxwell_slip::Entry,
    &one_sided_plays::Entry,
    &rate_dependent_plays::Entry,
    &activated_plays::Entry,
    &dead_zone_plays::Entry,
    &generalised_play::Entry,
    &krasnoselskii_pokrovskii::Entry,
    &preisach::Entry,
    &preisach::density::Entry,
    &jiles_atherton::Entry,
];

impl FamilyForm {
    /// All families, with their usual numbers of elements.
    pub fn all() -> impl Iterator<Item = Self> {
        FAMILIES.iter().map(|&family| {
            let usual = family.elements().map_or(0, |elements| elements.usual);
            Self::of(family, usual)
        })
    }
}
