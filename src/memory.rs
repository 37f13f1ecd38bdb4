//! How much memory a run may take, and whether what it plans fits.

use crate::{Error, Result};
use std::fmt::{self, Display};

/// Share of the free memory that a run takes by default.
const DEFAULT_SHARE: f64 = 0.75;

/// Most memory that a run is to take, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MemoryLimit(pub u64);

impl MemoryLimit {
    /// Three quarters of what is free, with what this process has already; no limit where the system
    /// does not tell.
    pub fn of_system() -> Self {
        let free = number("/proc/meminfo", "MemAvailable:");
        Self(free.map_or(u64::MAX, |free| {
            (free as f64 * DEFAULT_SHARE) as u64 + resident().unwrap_or(0)
        }))
    }

    /// Reads `800M`, `2.5G` or a number of bytes.
    ///
    /// # Errors
    /// When it is no such size, or less than a run of any map needs.
    pub fn parse(text: &str) -> Result<Self> {
        let units = [("K", 1_u64 << 10), ("M", 1 << 20), ("G", 1 << 30), ("T", 1 << 40)];
        let upper = text.trim().to_ascii_uppercase();
        let digits = upper.trim_end_matches("IB").trim_end_matches('B');
        let unit = units.iter().find_map(|(u, n)| Some((digits.strip_suffix(u)?, *n)));
        let (digits, unit) = unit.unwrap_or((digits, 1));
        let bytes = digits.trim().parse::<f64>().ok().map(|n| n * unit as f64);
        let usable = bytes.filter(|b| *b >= f64::from(1 << 24) && *b < 1e18);
        usable.map(|b| Self(b as u64)).ok_or_else(|| {
            Error::setting(
                "--memory-limit",
                format!("{text:?}: give a size from 16M up, such as 2G"),
            )
        })
    }

    /// What is left of it.
    pub fn left(self) -> u64 {
        self.0.saturating_sub(resident().unwrap_or(0))
    }
}

impl Display for MemoryLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} MiB", self.0 >> 20)
    }
}

/// Resident size of this process in bytes, where the system tells it.
fn resident() -> Option<u64> {
    number("/proc/self/status", "VmRSS:")
}

/// Makes [`peak`] begin anew, where the system can.
pub(crate) fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Largest resident size of this process so far in bytes, where the system tells it.
pub fn peak() -> Option<u64> {
    number("/proc/self/status", "VmHWM:")
}

/// A size in bytes from a file of the system with lines of names and KiB.
fn number(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let bytes = |text| MemoryLimit::parse(text).ok().map(|m| m.0);
        assert_eq!(bytes("800M"), Some(800 << 20));
        assert_eq!(bytes(" 2.5 GiB "), Some(5 << 29));
        assert_eq!(bytes("33554432"), Some(1 << 25));
        for text in ["", "M", "12", "-3G", "nan", "inf", "1e99", "2X"] {
            assert_eq!(bytes(text), None, "{text}");
        }
    }

    #[test]
    fn a_process_takes_some_memory_where_that_is_told() {
        if let (Some(now), Some(most)) = (resident(), peak()) {
            assert!(now > 1 << 20 && most >= now);
            assert!(MemoryLimit::of_system().0 > now);
            assert!(MemoryLimit(now / 2).left() == 0);
        }
    }
}
