//! The plan in words.

use std::fmt;

use super::FramePlan;

impl fmt::Display for FramePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(f, "{width}x{height}, {} sample{}", self.samples, if self.samples == 1 { "" } else { "s" })?;
        writeln!(f, "passes")?;
        for p in &self.passes {
            writeln!(f, "  {:<22}{}", p.pass.name(), p.reason)?;
        }
        writeln!(f, "not needed")?;
        for s in &self.skipped {
            writeln!(f, "  {:<22}{}", s.what, s.reason)?;
        }
        writeln!(f, "buffers")?;
        for b in &self.buffers {
            writeln!(f, "  {:<22}{}{}", b.name, bytes(b.bytes), if b.exact { "" } else { " (estimate)" })?;
        }
        writeln!(f, "  {:<22}{}", "total", bytes(self.total_bytes()))?;
        let estimate = if self.capture.is_whole() { " (estimate; the count decides)" } else { "" };
        match self.bands.len() {
            1 => write!(f, "one band{estimate}"),
            n => write!(f, "{n} bands, {} rows of apron{estimate}", self.apron),
        }
    }
}

fn bytes(n: u64) -> String {
    match n {
        0..1_000 => format!("{n} B"),
        1_000..1_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.2} GB", n as f64 / 1e9),
    }
}
