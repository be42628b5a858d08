//! The page's types name no field that the server does not answer with.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

/// Types of the page under another name than the server's.
const RENAMED: [(&str, &str); 11] = [
    ("CurveAxis", "Axis"),
    ("Inspection", "InspectionSummary"),
    ("Channel", "ChannelSummary"),
    ("Options", "OptionsOffered"),
    ("Drive", "DriveSummary"),
    ("Together", "ProspectsTogether"),
    ("Candidate", "CandidateSummary"),
    ("Comparison", "ComparisonSummary"),
    ("AxesComparison", "ModesComparisonSummary"),
    ("Running", "Live"),
    ("Controller", "TrackedController"),
];
/// Types that are no answer of the server.
const OF_THE_PAGE: [&str; 1] = ["Schema"];

/// Fields of each interface of the page: lines of an interface at its first level.
fn of_the_page() -> BTreeMap<String, BTreeSet<String>> {
    let mut found = BTreeMap::<String, BTreeSet<String>>::new();
    let mut name = None;
    for line in include_str!("../page/src/api/types.ts").lines() {
        if let Some(rest) = line.strip_prefix("export interface ") {
            name = rest.split([' ', '<']).next().map(str::to_owned);
        } else if line == "}" {
            name = None;
        } else if let (Some(name), Some(field)) = (&name, line.strip_prefix("  "))
            && field.starts_with(|c: char| c.is_ascii_lowercase())
            && let Some((field, _)) = field.split_once(':')
        {
            found.entry(name.clone()).or_default().insert(field.trim_end_matches('?').to_owned());
        }
    }
    found
}

/// Names of the properties of a schema, those of its parts with them.
fn properties(schema: &Value, all: &Value, names: &mut BTreeSet<String>) {
    if let Some(reference) = schema["$ref"].as_str() {
        properties(&all[reference.rsplit('/').next().unwrap()], all, names);
    }
    names.extend(schema["properties"].as_object().into_iter().flatten().map(|(name, _)| name.clone()));
    for parts in ["allOf", "anyOf", "oneOf"] {
        for part in schema[parts].as_array().into_iter().flatten() {
            properties(part, all, names);
        }
    }
}

#[test]
fn the_page_reads_what_the_server_answers() {
    let document = serde_json::to_value(hysteron_app::document()).unwrap();
    let mut schemas = document["components"]["schemas"].clone();
    // What an event carries is no answer of a route.
    schemas["LiveUpdate"] = schemars::schema_for!(hysteron_app::api::LiveUpdate).to_value();
    schemas["RequestProgress"] = schemars::schema_for!(hysteron_app::api::RequestProgress).to_value();
    let schemas = &schemas;
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (name, fields) in of_the_page() {
        if OF_THE_PAGE.contains(&name.as_str()) {
            continue;
        }
        let renamed = RENAMED.iter().find(|(own, _)| *own == name).map(|(_, theirs)| (*theirs).to_owned());
        let theirs = renamed.unwrap_or_else(|| name.clone());
        // A name of the library and one of the interface may be the same: the second has a number.
        let candidates = schemas.as_object().unwrap().iter().filter(|(key, _)| {
            key.strip_prefix(theirs.as_str()).is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit()))
        });
        let known: Vec<BTreeSet<String>> = candidates
            .map(|(_, schema)| {
                let mut names = BTreeSet::new();
                properties(schema, schemas, &mut names);
                names
            })
            .collect();
        let missing = known.iter().map(|known| fields.difference(known).cloned().collect::<Vec<_>>());
        match missing.min_by_key(Vec::len) {
            None => wrong.push(format!("the server has no {theirs} (the page's {name})")),
            Some(missing) if !missing.is_empty() => {
                wrong.push(format!("{theirs} has no {}", missing.join(", ")));
            }
            Some(_) => checked += 1,
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(checked > 25, "{checked} types were found");
}
