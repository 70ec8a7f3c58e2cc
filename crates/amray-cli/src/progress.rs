//! Progress of long work: on a terminal only, nothing where standard error is piped.

use std::io::{self, IsTerminal};
use std::sync::OnceLock;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work that is done by then shows nothing.
const QUICK: Duration = Duration::from_millis(500);
/// Between two pictures of a spinner.
const TICK: Duration = Duration::from_millis(100);

/// Runs `work` under a progress bar that shows `what`; `work` tells the share that is done, 0 to 1.
pub(crate) fn with_progress<R>(what: &str, work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> R) -> R {
    let bar = LateBar { what, start: Instant::now(), bar: OnceLock::new() };
    let result = work(&|share| bar.report(share));
    if let Some(bar) = bar.bar.get() {
        bar.finish_and_clear();
    }
    result
}

/// Runs `work`, which cannot tell how far it is, while a spinner turns beside `what`.
pub(crate) fn with_spinner<R>(what: &str, work: impl FnOnce() -> R) -> R {
    if !io::stderr().is_terminal() {
        return work();
    }
    let (running, ended) = mpsc::channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || {
            if ended.recv_timeout(QUICK) == Err(RecvTimeoutError::Timeout) {
                let spinner = drawn(None, "{msg:>12} {spinner} {elapsed}", what);
                spinner.enable_steady_tick(TICK);
                // Nothing is ever sent: the other end goes away when the work is done, even by a panic.
                let _ = ended.recv();
                spinner.finish_and_clear();
            }
        });
        let _running = running;
        work()
    })
}

/// A progress bar that appears only when the work proves not to be quick.
struct LateBar<'a> {
    what: &'a str,
    start: Instant,
    bar: OnceLock<ProgressBar>,
}

impl LateBar<'_> {
    /// Shows the share that is done, 0 to 1.
    fn report(&self, share: f64) {
        /// The bar's own unit; shares are rounded to it.
        const WHOLE: u64 = 1000;
        if self.start.elapsed() < QUICK {
            return;
        }
        let template = "{msg:>12} {bar:40} {percent:>3} % {eta}";
        let bar = self.bar.get_or_init(|| drawn(Some(WHOLE), template, self.what).with_elapsed(self.start.elapsed()));
        bar.set_position((share.clamp(0.0, 1.0) * WHOLE as f64) as u64);
    }
}

/// A bar on standard error; indicatif itself shows nothing where that is no terminal.
fn drawn(length: Option<u64>, template: &str, what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr_with_hz(10));
    bar.set_style(ProgressStyle::with_template(template).expect("the template is valid"));
    bar.with_message(what.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_work_has_no_bar() {
        let bar = |start: Instant| LateBar { what: "working", start, bar: OnceLock::new() };
        let quick = bar(Instant::now() + Duration::from_secs(3600));
        quick.report(0.5);
        assert!(quick.bar.get().is_none());
        let long = bar(Instant::now() - QUICK);
        long.report(0.5);
        assert_eq!(long.bar.get().unwrap().position(), 500);
    }

    #[test]
    fn work_gives_its_result() {
        assert_eq!(with_progress("working", |progress| [0.0, 2.0].map(progress).len()), 2);
        assert_eq!(with_spinner("working", || 7), 7);
    }
}
