//! How much memory there is, where the system says (Linux).

use std::path::Path;

/// The most that this process has had, bytes.
pub(super) fn peak() -> Option<u64> {
    kilobytes("/proc/self/status", "VmHWM:")
}

/// What is free for programs, bytes: of the machine, and of the control group that the process
/// may use no more than.
pub(super) fn free() -> Option<u64> {
    let machine = kilobytes("/proc/meminfo", "MemAvailable:");
    let group = group(Path::new("/sys/fs/cgroup"));
    machine.into_iter().chain(group).min()
}

/// Refuses what needs more bytes than are free: one line that names it and says what to do.
pub(super) fn check(
    needed: u64,
    advice: &str,
    what: impl Fn() -> String,
) -> Result<(), super::Failure> {
    against(free(), needed, advice, what)
}

fn against(
    free: Option<u64>,
    needed: u64,
    advice: &str,
    what: impl Fn() -> String,
) -> Result<(), super::Failure> {
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    match free.filter(|free| needed > *free) {
        None => Ok(()),
        Some(free) => Err(format!(
            "{} needs {:.1} GB of memory, but only {:.1} GB are free; {advice}",
            what(),
            gigabytes(needed),
            gigabytes(free)
        )
        .into()),
    }
}

fn kilobytes(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// What is left of a control group's limit. Pages of files are given back when needed.
fn group(folder: &Path) -> Option<u64> {
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).ok();
    let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
    let files = text("memory.stat")
        .and_then(|text| text.lines().find_map(|line| line.strip_prefix("file ")?.parse().ok()));
    let used = number("memory.current")?.saturating_sub(files.unwrap_or(0));
    Some(number("memory.max")?.saturating_sub(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_control_group_leaves() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
        };
        assert_eq!(group(folder.path()), None);
        write("memory.max", "max\n");
        write("memory.current", "700\n");
        assert_eq!(group(folder.path()), None);
        write("memory.max", "1000\n");
        assert_eq!(group(folder.path()), Some(300));
        write("memory.stat", "anon 500\nfile 200\n");
        assert_eq!(group(folder.path()), Some(500));
        write("memory.current", "1300\n");
        assert_eq!(group(folder.path()), Some(0));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let against = |free| against(free, 3_000_000_000, "give less", || "this".to_owned());
        assert!(against(None).is_ok() && against(Some(3_000_000_000)).is_ok());
        assert_eq!(
            against(Some(1_499_000_000)).unwrap_err().to_string(),
            "this needs 3.0 GB of memory, but only 1.5 GB are free; give less"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_says() {
        let least = 1 << 20;
        assert!(peak().is_some_and(|bytes| bytes > least));
        assert!(free().is_some_and(|bytes| bytes > least));
    }
}
