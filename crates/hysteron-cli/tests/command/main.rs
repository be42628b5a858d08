//! The command line's promises, one file each, tested by running the command.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test stops at the first surprise"
)]

mod adapt_follows_a_device;
mod article_is_reproduced;
mod bad_models_are_refused;
mod bad_records_are_refused;
mod bench;
mod corrected_models_err_less;
mod every_command;
mod excite_writes_drives;
mod forces_are_identified;
mod frequency_responses_are_explained;
mod identify_can_be_interrupted;
mod identify_makes_a_model;
mod inputs_are_kept;
mod inspect_tells_what_is_in_a_record;
mod invert_follows_a_reference;
mod models_are_exported;
mod models_are_realised;
mod optimizers_are_compared;
mod oscillators_are_identified;
mod outputs_are_checked_first;
mod outputs_come_together;
mod prepare_makes_a_record;
mod public_records_are_explained;
mod recalibrate_finds_gain_and_delay;
mod results_are_unchanged;
mod rig_makes_records;
mod schema_and_completions_are_printed;
mod several_axes_are_followed;
mod several_axes_are_identified;
mod simulate_writes_a_record;
mod structures_are_compared;
mod the_next_drive_is_designed;
mod the_page_is_served;
mod track_follows_in_closed_loop;
mod tutorial_runs;
mod usage_errors_exit_2;
mod validate_scores_as_promised;
mod written_files_are_plain;
