//! Progress bar with the time left, on standard error; nothing where standard error is not a terminal.

use std::borrow::Cow;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar that goes away when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of `steps` steps, labelled with what is being done.
    pub fn new(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
        let template = "{prefix} {wide_bar} {pos}/{len}, {eta} left {msg}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.set_prefix(what.to_owned());
        Progress(bar)
    }

    /// There are `steps` steps after all.
    pub fn set_length(&self, steps: u64) {
        self.0.set_length(steps);
    }

    /// `done` steps are done; `remark` is shown behind the bar, e.g. the best cost so far.
    pub fn set(&self, done: u64, remark: impl Into<Cow<'static, str>>) {
        self.0.set_position(done);
        self.0.set_message(remark);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
