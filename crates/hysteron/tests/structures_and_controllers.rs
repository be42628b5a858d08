//! Structures are compared and references are followed without a crate behind the facade.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron::{Compare, Identify, Record, Signal, TrackOptions};
use std::f64::consts::TAU;

/// A plain stage with a bend, along three sines.
fn records(folder: &std::path::Path) -> Vec<Record> {
    let files = [1.0, 2.0, 3.0].map(|frequency_hz| {
        let line = |k: u32| {
            let t = f64::from(k) / 500.0;
            let u = 2.0 - 2.0 * (TAU * frequency_hz * t).cos();
            let lag = (TAU * frequency_hz * t).sin();
            format!("{t},{u},{}\n", 15.0 * u - 0.25 * u * u - lag + 0.002 * (61.0 * t * t).sin())
        };
        let text = std::iter::once("t_s,u_V,y_um\n".to_owned()).chain((0..1000).map(line));
        let path = folder.join(format!("sine_{frequency_hz}.csv"));
        std::fs::write(&path, text.collect::<String>()).unwrap();
        path
    });
    hysteron::read(files).unwrap()
}

#[test]
fn the_preferred_structure_is_identified_and_its_inverse_follows_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    let records = records(folder.path());
    let candidates = ["none", "none+prandtl-ishlinskii"].map(|name| name.parse().unwrap());
    let comparison = Compare::new(&records).candidates(candidates).run().unwrap();
    let fit = comparison.identify().unwrap();
    let alone = Identify::new(&records).run().unwrap();
    assert_eq!(fit.scores().len(), 3);
    assert!(comparison.report().to_html().contains(&comparison.preferred().unwrap().to_string()));
    assert_eq!(serde_json::to_value(&comparison).unwrap()["candidates"].as_array().unwrap().len(), 2);

    let reference = (0..800).map(|k| 20.0 + 10.0 * (TAU * f64::from(k) / 400.0).sin()).collect();
    let reference = Signal::uniform(reference, 500.0, "um");
    let found = alone.model.track(&reference, &TrackOptions::default(), None).unwrap();
    assert!(found.plant.words.contains("simulated"));
    assert!(found.runs.len() > 3, "{}", found.runs.len());
}
