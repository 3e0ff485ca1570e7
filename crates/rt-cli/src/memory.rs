//! Memory limit, available memory, and peak memory of the process.

use std::path::Path;

use rt_scene_io::MemoryError;

use crate::error::CliError;

/// Refuses files that need more memory than the limit. The names of the needs complete the sentence "most of it, ... for ...".
pub(crate) fn check(limit: Option<u64>, file: &Path, needs: &[(String, u64)]) -> Result<(), CliError> {
    let predicted = needs.iter().fold(0_u64, |sum, (_, bytes)| sum.saturating_add(*bytes));
    match (limit, needs.iter().max_by_key(|(_, bytes)| *bytes)) {
        (Some(budget), Some((largest, most))) if predicted > budget => {
            let cause = MemoryError { predicted, budget, largest: largest.clone(), most: *most };
            Err(CliError::Memory { file: file.to_owned(), cause })
        }
        _ => Ok(()),
    }
}

/// Available memory in bytes: the minimum of the control groups, the machine, and the address space of the process (`ulimit -v`).
/// `None` if unknown.
#[cfg(target_os = "linux")]
pub(crate) fn available_bytes() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| kibibytes(&text, "MemTotal:"));
    let groups = read("/proc/self/cgroup").map(|text| group_files(&text)).unwrap_or_default();
    let allowed = groups.iter().filter_map(|file| read(file)?.trim().parse().ok());
    let address_space = read("/proc/self/limits").and_then(|text| soft_limit(&text, "Max address space"));
    allowed.chain(machine).chain(address_space).min()
}

/// Unknown on this system.
#[cfg(not(target_os = "linux"))]
pub(crate) const fn available_bytes() -> Option<u64> {
    None
}

/// Limit files of the control groups of `/proc/self/cgroup` and of their parents (cgroups(7)). A group without a limit has `max`, or
/// a huge number.
#[cfg(any(target_os = "linux", test))]
fn group_files(groups: &str) -> Vec<String> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let mut path = path.trim_end_matches('/');
        loop {
            files.push(format!("{root}{path}/{file}"));
            let Some((parent, _)) = path.rsplit_once('/') else { break };
            path = parent;
        }
    }
    files
}

/// Soft limit of a line of `/proc/self/limits` (proc(5)); `None` for `unlimited`.
#[cfg(any(target_os = "linux", test))]
fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let values = limits.lines().find_map(|line| line.strip_prefix(name))?;
    values.split_whitespace().next()?.parse().ok()
}

/// Peak physical memory of the process in bytes; `None` if unknown.
#[cfg(target_os = "linux")]
pub(crate) fn peak_bytes() -> Option<u64> {
    kibibytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Peak physical memory of the process in bytes; `None` if unknown.
#[cfg(not(target_os = "linux"))]
pub(crate) const fn peak_bytes() -> Option<u64> {
    None
}

/// Value of a line of a proc(5) file, which has units of 1024 bytes.
#[cfg(any(target_os = "linux", test))]
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_found_among_the_lines() {
        let peak = |text: &str| kibibytes(text, "VmHWM:");
        assert_eq!(peak("Name:\tx\nVmPeak:\t  900 kB\nVmHWM:\t    1536 kB\n"), Some(1_572_864));
        assert_eq!(peak("Name:\tx\n"), None);
        assert_eq!(peak("VmHWM:\tmany kB\n"), None);
    }

    #[test]
    fn the_soft_limit_of_the_address_space_is_found_among_the_lines() {
        let text = "Limit    Soft Limit   Hard Limit   Units\nMax locked memory  4096  8192  bytes\n\
                    Max address space         307200000            unlimited            bytes\n";
        assert_eq!(soft_limit(text, "Max address space"), Some(307_200_000));
        assert_eq!(soft_limit(&text.replace("307200000", "unlimited"), "Max address space"), None);
        assert_eq!(soft_limit("", "Max address space"), None);
    }

    #[test]
    fn limits_of_parent_groups_count() {
        assert_eq!(
            group_files("0::/user/shell\n"),
            ["/sys/fs/cgroup/user/shell/memory.max", "/sys/fs/cgroup/user/memory.max", "/sys/fs/cgroup/memory.max"]
        );
        assert_eq!(group_files("0::/\n"), ["/sys/fs/cgroup/memory.max"]);
        assert_eq!(
            group_files("4:cpu,memory:/a:b\n2:pids:/a\nnonsense\n"),
            ["/sys/fs/cgroup/memory/a:b/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.limit_in_bytes"]
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_process_uses_some_memory() {
        let peak = peak_bytes().expect("Linux says");
        assert!((100_000..1 << 40).contains(&peak), "{peak}");
        assert!(available_bytes().expect("Linux says") > peak);
    }
}
