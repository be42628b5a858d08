//! Records of the simulated bench, and drives, in the workspace.

use hysteron_io::atomic_file::write_atomically_with;
use hysteron_io::{save_json, write_csv_to, write_record};
use hysteron_model::record::{TimeBase, Unit};
use hysteron_rig::{CampaignRun, Role as Purpose, run_campaign};
use serde::Serialize;
use serde_json::Value;

use crate::api::{BenchMade, BenchRequest, DriveMade, DriveRequest, RecordSettings, Role};
use crate::command;
use crate::draw::{Along, over_time};
use crate::refused::{Answer, Refused};
use crate::workspace::{Kind, Workspace};

/// Folder of the records unless named otherwise.
const FOLDER: &str = "bench";
/// Most truths and plans that a folder of the bench keeps.
const MOST_TRUTHS: u32 = 1000;
/// Width of the drawing unless given \[pixels\].
const PIXELS: usize = 800;

/// Measures a campaign on the simulated bench; records of the same name go to the trash folder.
///
/// # Errors
/// For a truth or a plan that cannot be simulated; if the files cannot be written.
pub(crate) fn measure(workspace: &Workspace, request: &BenchRequest) -> Answer<BenchMade> {
    let folder = if request.folder.is_empty() { FOLDER } else { &request.folder };
    let place = workspace.path(folder)?;
    let runs = run_campaign(&request.truth, &request.plan, request.seed).map_err(Refused::bad)?;
    std::fs::create_dir_all(&place).map_err(Refused::failed)?;
    let truth = format!("{folder}/{}", kept_beside(&place, "truth", &request.truth)?);
    let plan = format!("{folder}/{}", kept_beside(&place, "plan", &request.plan)?);
    let command = command::rig(folder, request.seed, &truth, &plan);
    let mut made = BenchMade { records: Vec::new(), samples: 0, command };
    for CampaignRun { run, role, .. } in &runs {
        let id = format!("{folder}/{}.csv", run.record.name);
        let path = workspace.to_write(&id, Kind::Record)?;
        write_atomically_with(&path, |out| {
            for comment in &run.comments {
                writeln!(out, "# {comment}")?;
            }
            write_csv_to(out, &run.record)
        })
        .map_err(Refused::failed)?;
        let role = match role {
            Purpose::QuasiStatic | Purpose::Sweep => Role::Auto,
            Purpose::Validation { .. } | Purpose::Tracking | Purpose::NestedLoops => Role::Validate,
        };
        workspace.history.keep_settings(&id, &RecordSettings { role, ..RecordSettings::default() })?;
        made.samples += run.record.len();
        made.records.push(id);
    }
    workspace.history.add_action(&made.command)?;
    workspace.look();
    Ok(made)
}

/// Keeps a truth or a plan and returns the name of its file: another one than those of other values, which
/// earlier commands name.
fn kept_beside(place: &std::path::Path, stem: &str, value: &impl Serialize) -> Answer<String> {
    let value = serde_json::to_value(value).map_err(Refused::failed)?;
    for k in 1..=MOST_TRUTHS {
        let name = if k == 1 { format!("{stem}.json") } else { format!("{stem}-{k}.json") };
        let path = place.join(&name);
        let before = std::fs::read(&path).ok();
        match before {
            Some(bytes) if serde_json::from_slice::<Value>(&bytes).ok().as_ref() != Some(&value) => {}
            Some(_) => return Ok(name),
            None => {
                save_json(&path, &value, true).map_err(Refused::failed)?;
                return Ok(name);
            }
        }
    }
    Err(Refused::conflict(format!("the folder has {MOST_TRUTHS} files called {stem}")))
}

/// Makes a drive.
///
/// # Errors
/// For a specification that cannot be met; if the file cannot be written.
pub(crate) fn make_drive(workspace: &Workspace, request: &DriveRequest) -> Answer<DriveMade> {
    let made = request.specification.generate().map_err(Refused::bad)?;
    if let Some(file) = &request.save {
        if workspace.path(file)?.exists() {
            return Err(Refused::conflict(format!("`{file}` is there already")));
        }
        let path = workspace.to_write(file, Kind::Record)?;
        write_record(&path, &made.to_record()).map_err(Refused::failed)?;
        workspace.look();
    }
    let time = TimeBase::uniform(made.sample_rate_hz);
    let along = Along::new("u", &Unit::new("V"), &made.samples_v);
    let pixels = request.pixels.unwrap_or(PIXELS);
    Ok(DriveMade {
        summary: made.summary(),
        drive: over_time(&time, &along, 0..made.samples_v.len(), pixels),
        file: request.save.clone(),
    })
}
