//! Identifiers: paths relative to the workspace.

use std::path::{Component, Path, PathBuf};

use crate::refused::{Answer, Refused};

/// Folder for what was deleted.
pub(crate) const TRASH: &str = "trash";
/// File of the history.
pub(crate) const HISTORY: &str = "hysteron.sqlite";
/// Longest identifier \[bytes\].
const LONGEST: usize = 512;
/// Longest name of a file or folder \[bytes\]: what is written beside a file has an ending more, and systems
/// allow 255.
const LONGEST_PART: usize = 200;
/// Deepest folder that is looked into.
pub(super) const DEEPEST: usize = 4;

/// The path of an identifier below `folder`.
///
/// # Errors
/// For one that is absolute, leads out of the folder, names a hidden file or the trash.
pub(crate) fn path_of(folder: &Path, id: &str) -> Answer<PathBuf> {
    let refuse = |why: &str| Err(Refused::bad(format!("`{}` is no name in the workspace: {why}", shown(id))));
    if id.is_empty() || id.len() > LONGEST {
        return refuse("it must have 1 to 512 bytes");
    }
    if id.contains(['\\', '\0']) || id.chars().any(char::is_control) {
        return refuse("it has a backslash or a control character");
    }
    let relative = Path::new(id);
    let mut parts = 0;
    for part in relative.components() {
        let Component::Normal(name) = part else { return refuse("it must lead into the folder") };
        let name = name.to_string_lossy();
        if name.len() > LONGEST_PART {
            return refuse("a name in it is longer than 200 bytes");
        }
        if name.starts_with('.') {
            return refuse("hidden files are not shown");
        }
        if parts == 0 && (name == TRASH || name.starts_with(HISTORY)) {
            return refuse("it is kept for the program");
        }
        parts += 1;
    }
    if parts > DEEPEST || id.ends_with('/') || id.contains("//") {
        return refuse("it must name a file, in at most three folders");
    }
    let path = folder.join(relative);
    // A link may lead out of the folder.
    let existing = path.ancestors().find_map(|a| a.canonicalize().ok());
    if existing.is_some_and(|existing| !existing.starts_with(folder)) {
        return refuse("it leads out of the folder");
    }
    Ok(path)
}

/// The identifier of a path below `folder`.
pub(crate) fn id_of(folder: &Path, path: &Path) -> Option<String> {
    let relative = path.strip_prefix(folder).ok()?;
    let parts: Option<Vec<&str>> = relative.components().map(|part| part.as_os_str().to_str()).collect();
    parts.map(|parts| parts.join("/")).filter(|id| !id.is_empty())
}

/// Folder of an identifier, empty for the workspace itself.
pub(crate) fn device_of(id: &str) -> &str {
    id.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Name of the file without folder and ending.
pub(crate) fn stem_of(id: &str) -> &str {
    let name = id.rsplit_once('/').map_or(id, |(_, name)| name);
    name.split_once('.').map_or(name, |(stem, _)| stem)
}

/// An identifier for messages, shortened.
pub(crate) fn shown(id: &str) -> String {
    id.chars().filter(|c| !c.is_control()).take(80).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn an_identifier_stays_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        for good in ["run.csv", "stage/run.csv", "a b <script>.csv", "µ.csv"] {
            assert_eq!(path_of(&folder, good).unwrap(), folder.join(good));
            assert_eq!(id_of(&folder, &folder.join(good)).unwrap(), good);
        }
        for bad in [
            "",
            "/etc/passwd",
            "../x.csv",
            "a/../../x",
            ".hidden",
            "a/.b",
            "trash/x",
            "hysteron.sqlite",
            "a\\b",
            "a\0",
            "a/",
            "a//b",
            "./a/..",
            "a\nb",
            "a/b/c/d/e",
        ] {
            assert!(path_of(&folder, bad).is_err(), "{bad:?}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("/etc", folder.join("link")).unwrap();
            assert!(path_of(&folder, "link/passwd").is_err());
        }
    }

    #[test]
    fn the_folder_is_the_device() {
        assert_eq!((device_of("a/b.csv"), device_of("b.csv")), ("a", ""));
        assert_eq!((stem_of("a/b.partial.json"), stem_of("b")), ("b", "b"));
    }
}
