//! All commands of a workspace as scripts.

use crate::api::Command;

/// A shell script and a Python script of what was done, in order.
pub(crate) fn scripts(actions: &[Command]) -> (String, String) {
    let mut shell = "#!/bin/sh -e\n# everything done in this folder, in order\n".to_owned();
    let mut python =
        "# everything done in this folder, in order\nimport hysteron_models as hy\n\n".to_owned();
    for action in actions {
        for (script, line) in [(&mut shell, &action.shell), (&mut python, &action.python)] {
            if !line.is_empty() {
                script.push_str(line);
                script.push('\n');
            }
        }
    }
    (shell, python)
}
