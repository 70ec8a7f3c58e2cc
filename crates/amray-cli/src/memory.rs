//! How much memory the process takes, where the system tells.

/// Bytes in physical memory now.
pub(crate) fn resident() -> Option<u64> {
    of_status("VmRSS:")
}

/// The most bytes that were in physical memory at once.
pub(crate) fn peak_resident() -> Option<u64> {
    of_status("VmHWM:")
}

/// Bytes in physical memory that are the process's own now: mapped files, which the system can drop at any time, are
/// left out.
pub(crate) fn private() -> Option<u64> {
    of_status("RssAnon:")
}

/// Bytes that programs can still get without making the system swap.
pub(crate) fn available() -> Option<u64> {
    line_of("/proc/meminfo", "MemAvailable:")
}

/// A line of Linux's process status (proc(5)), which counts in units of 1024 bytes.
fn of_status(key: &str) -> Option<u64> {
    line_of("/proc/self/status", key)
}

fn line_of(path: &str, key: &str) -> Option<u64> {
    let status = std::fs::read_to_string(path).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|count| count * 1024)
}
