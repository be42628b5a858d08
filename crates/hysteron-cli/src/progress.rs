//! Progress with the time left, on standard error: a bar on a terminal, elsewhere a line every ten seconds.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use hysteron_identify::{Event, Watch};
use hysteron_report::number::significant;

use crate::console;
use crate::interrupt::Interrupt;

/// Time between the lines where standard error is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(10);
/// Time between two pictures of work that reports nothing.
const BETWEEN_TICKS: Duration = Duration::from_millis(250);
/// Steps of a bar.
const STEPS: f64 = 1000.0;

/// Shows the progress of a computation; the first Ctrl-C stops it.
pub fn watch(interrupt: &Interrupt) -> Watch<'static> {
    let mut show = show();
    let told = move |event: &Event<'_>| {
        show(event);
        ControlFlow::Continue(())
    };
    Watch::new(told).stopped_by(interrupt.stop())
}

/// Shows the progress of one computation, from its first event on.
pub fn show() -> impl FnMut(&Event<'_>) + Send {
    let mut shown: Option<Progress> = None;
    move |event| shown.get_or_insert_with(Progress::new).tell(event)
}

/// Shows on a terminal what goes on, and for how long, during work that reports nothing itself.
pub fn during<T>(told: &'static str, work: impl FnOnce() -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_message(told);
    let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    bar.enable_steady_tick(BETWEEN_TICKS);
    let done = work();
    bar.finish_and_clear();
    done
}

/// Progress display of one computation; the bar is cleared on drop.
struct Progress {
    bar: ProgressBar,
    began: Instant,
    /// Intervals whose line is printed; `None` on a terminal.
    lines: Option<u64>,
}

impl Progress {
    fn new() -> Self {
        let bar = ProgressBar::with_draw_target(Some(STEPS as u64), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{wide_bar} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let lines = (!std::io::stderr().is_terminal()).then_some(0);
        Self { bar, began: Instant::now(), lines }
    }

    fn tell(&mut self, event: &Event<'_>) {
        let elapsed = self.began.elapsed();
        let told = in_words(event, elapsed);
        if let Some(printed) = &mut self.lines {
            let intervals = elapsed.as_secs() / BETWEEN_LINES.as_secs();
            if intervals > *printed {
                *printed = intervals;
                console::message(&format!("progress: {told}"));
            }
        }
        self.bar.set_position((STEPS * event.fraction) as u64);
        self.bar.set_message(told);
    }
}

/// `42 %, joint fit, best RMSE 0.012345, 35 s left`.
fn in_words(event: &Event<'_>, elapsed: Duration) -> String {
    let mut text = format!("{:.0} %, {}", 100.0 * event.fraction, event.stage);
    if let Some(cost) = event.cost {
        text += &format!(", best RMSE {}", significant(cost, 5));
    }
    if let Some(left) = event.time_left(elapsed) {
        text += &format!(", {:.0} s left", left.as_secs_f64());
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
        let text = in_words(&Event::new("joint fit", 0.42, Some(0.012345)), Duration::from_secs(42));
        assert_eq!(text, "42 %, joint fit, best RMSE 0.012345, 58 s left");
        assert_eq!(in_words(&Event::new("modes", 0.0, None), Duration::from_secs(1)), "0 %, modes");
    }
}
