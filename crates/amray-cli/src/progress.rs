//! Progress bars for long work: on a terminal only, nothing where standard error is piped.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Runs `work` under a progress bar that shows `what`; `work` tells the share that is done, 0 to 1.
pub(crate) fn with_progress<R>(what: &str, work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> R) -> R {
    /// The bar's own unit; shares are rounded to it.
    const WHOLE: u64 = 1000;
    // indicatif itself shows nothing where standard error is no terminal.
    let bar = ProgressBar::with_draw_target(Some(WHOLE), ProgressDrawTarget::stderr_with_hz(10));
    let style = ProgressStyle::with_template("{msg:>12} {bar:40} {percent:>3} % {eta}").expect("the template is valid");
    bar.set_style(style);
    bar.set_message(what.to_owned());
    // Quick work shows no bar at all.
    bar.enable_steady_tick(Duration::from_millis(500));
    let result = work(&|share| bar.set_position((share.clamp(0.0, 1.0) * WHOLE as f64) as u64));
    bar.finish_and_clear();
    result
}
