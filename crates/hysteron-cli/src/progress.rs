//! Progress with the time left, on standard error: a bar on a terminal, elsewhere a line every ten seconds.

use std::borrow::Cow;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use hysteron_identify::{Event, Watch};
use hysteron_report::number::significant;

use crate::console;
use crate::interrupt::Interrupt;

/// Time between the lines where standard error is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Progress of one piece of work; a bar goes away when dropped.
pub struct Progress {
    bar: ProgressBar,
    lines: Option<Lines>,
}

/// Lines in the place of a bar.
struct Lines {
    what: String,
    began: Instant,
    /// Intervals that have had their line.
    printed: AtomicU64,
}

impl Progress {
    /// Of `steps` steps, labelled with what is being done.
    pub fn new(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
        let template = "{wide_bar} {percent} %, {eta} left, {prefix}{msg}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.set_prefix(what.to_owned());
        let lines = || Lines { what: what.to_owned(), began: Instant::now(), printed: AtomicU64::new(0) };
        Progress { bar, lines: (!std::io::stderr().is_terminal()).then(lines) }
    }

    /// `done` steps are done; `remark` is shown behind them, e.g. the best cost so far.
    pub fn set(&self, done: u64, remark: impl Into<Cow<'static, str>>) {
        let remark = remark.into();
        if let Some(lines) = &self.lines
            && lines.is_due()
        {
            let steps = self.bar.length().unwrap_or(done).max(1);
            console::message(&line(&lines.what, done, steps, lines.began.elapsed(), &remark));
        }
        self.bar.set_position(done);
        self.bar.set_message(remark);
    }
}

/// Steps of a bar that shows a fraction.
const STEPS: f64 = 1000.0;

/// Shows what work tells about itself until it ends; the first Ctrl-C stops it.
pub fn watch(interrupt: &Interrupt) -> Watch<'static> {
    let mut shown: Option<Progress> = None;
    let show = move |event: &Event<'_>| {
        let bar = shown.get_or_insert_with(|| Progress::new("", STEPS as u64));
        let mut remark = event.stage.to_owned();
        if let Some(cost) = event.cost {
            remark += &format!(", best RMSE {}", significant(cost, 5));
        }
        bar.set((STEPS * event.fraction) as u64, remark);
        ControlFlow::Continue(())
    };
    Watch::new(show).stopped_by(interrupt.stop())
}

impl Lines {
    /// Whether an interval has passed without a line, for one caller.
    fn is_due(&self) -> bool {
        let intervals = self.began.elapsed().as_secs() / BETWEEN_LINES.as_secs();
        self.printed.fetch_max(intervals, Ordering::Relaxed) < intervals
    }
}

/// `progress: 42 %, joint fit, best RMSE 0.0123, 35 s left`.
fn line(what: &str, done: u64, steps: u64, elapsed: Duration, remark: &str) -> String {
    let share = done.min(steps) as f64 / steps as f64;
    let mut text = format!("progress: {:.0} %", 100.0 * share);
    for part in [what, remark].into_iter().filter(|part| !part.is_empty()) {
        text += &format!(", {part}");
    }
    if share > 0.0 {
        text += &format!(", {:.0} s left", elapsed.as_secs_f64() * (1.0 / share - 1.0));
    }
    text
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_share_done_the_work_and_the_time_left() {
        let text = line("joint fit", 42, 100, Duration::from_secs(42), "best RMSE 0.0123");
        assert_eq!(text, "progress: 42 %, joint fit, best RMSE 0.0123, 58 s left");
        assert_eq!(line("modes", 0, 10, Duration::from_secs(1), ""), "progress: 0 %, modes");
    }
}
