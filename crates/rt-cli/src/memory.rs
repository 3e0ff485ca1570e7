//! How much memory the process used at most.

/// Bytes of physical memory that the process occupied at its peak; `None` where the system does not say.
#[cfg(target_os = "linux")]
pub(crate) fn peak_bytes() -> Option<u64> {
    peak_of_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Bytes of physical memory that the process occupied at its peak; `None` where the system does not say.
#[cfg(not(target_os = "linux"))]
pub(crate) const fn peak_bytes() -> Option<u64> {
    None
}

/// The high water mark in the text of `/proc/self/status`, which counts in units of 1024 bytes (proc(5)).
#[cfg(any(target_os = "linux", test))]
fn peak_of_status(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_found_among_the_lines() {
        assert_eq!(peak_of_status("Name:\tx\nVmPeak:\t  900 kB\nVmHWM:\t    1536 kB\n"), Some(1_572_864));
        assert_eq!(peak_of_status("Name:\tx\n"), None);
        assert_eq!(peak_of_status("VmHWM:\tmany kB\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_process_uses_some_memory() {
        let peak = peak_bytes().expect("Linux says");
        assert!((100_000..1 << 40).contains(&peak), "{peak}");
    }
}
