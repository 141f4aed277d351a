//! Options for reading a model, wherever a command reads one.

use clap::Args;

use crate::import::{ImportOptions, PartsBy};
use crate::session::{Importing, Limit, count, crease_angle, parts_named};

/// Options for reading a model. What is not said comes from the session, if there is one, and else from the configuration.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Import")]
pub struct ImportArgs {
    /// What becomes a part: node (what the file names), material, component (connected triangles), file, or auto: what suits
    /// the format
    #[arg(long, value_name = "BY", value_parser = parts)]
    pub parts: Option<Parts>,
    /// Show this material variant of the file, by name
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Smooth missing normals over edges that turn by at most this angle [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = crease_angle)]
    pub crease_angle: Option<f64>,
    /// Take at most this much, as in bytes=8G or triangles=1M; `pellucid config` lists the limits
    #[arg(long, value_name = "NAME=VALUE", value_parser = limit)]
    pub limit: Vec<(String, u64)>,
}

/// What becomes a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts(pub Option<PartsBy>);

fn parts(text: &str) -> Result<Parts, String> {
    parts_named(text).map(Parts)
}

/// Parses `NAME=VALUE`: a limit that there is, and a number that it holds.
fn limit(text: &str) -> Result<(String, u64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE, as in bytes=8G")?;
    let limit = Limit::named(name)?;
    let value = count(value)?;
    limit.set(&mut crate::import::Limits::default(), value)?;
    Ok((name.to_owned(), value))
}

impl ImportArgs {
    /// Import options: those of the line over those of a session, if there is one, over `configured`.
    pub fn options(&self, session: Option<&Importing>, configured: ImportOptions) -> ImportOptions {
        let mut options = match session {
            // A session says all that its picture depends on, also where it is as usual and therefore not written.
            Some(session) => session.options(&configured),
            None => configured,
        };
        if let Some(Parts(by)) = self.parts {
            options.parts = by;
        }
        if self.variant.is_some() {
            options.variant.clone_from(&self.variant);
        }
        options.crease_angle = self.crease_angle.unwrap_or(options.crease_angle);
        for (name, value) in &self.limit {
            if let Ok(limit) = Limit::named(name) {
                // The number was tried when the line was read.
                let _ = limit.set(&mut options.limits, *value);
            }
        }
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<ImportArgs, String> {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            import: ImportArgs,
        }
        let words = std::iter::once("test").chain(line.split_whitespace());
        <Line as clap::Parser>::try_parse_from(words).map(|l| l.import).map_err(|e| e.to_string())
    }

    #[test]
    fn the_line_counts_more_than_the_session_and_that_more_than_the_configuration() {
        let mut configured =
            ImportOptions { parts: Some(PartsBy::File), crease_angle: 60.0, ..ImportOptions::default() };
        configured.converters.insert("step".to_owned(), "x {in} {out}".to_owned());
        let line = parse("--parts material --variant red --limit bytes=1M --limit image_side=64").unwrap();
        let options = line.options(None, configured.clone());
        assert_eq!((options.parts, options.crease_angle), (Some(PartsBy::Material), 60.0));
        assert_eq!((options.variant.as_deref(), options.converters.len()), (Some("red"), 1));
        assert_eq!((options.limits.bytes, options.limits.image_side), (1 << 20, 64));
        let session = Importing { parts: Some(PartsBy::Component), ..Importing::default() };
        let options = ImportArgs::default().options(Some(&session), configured.clone());
        assert_eq!((options.parts, options.crease_angle), (Some(PartsBy::Component), 30.0));
        assert_eq!(options.converters, configured.converters);
        let options = parse("--parts auto --crease-angle 5").unwrap().options(Some(&session), configured);
        assert_eq!((options.parts, options.crease_angle), (None, 5.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_the_names_that_there_are() {
        for (line, word) in [
            ("--parts nodes", "did you mean 'node'"),
            ("--limit bites=1", "did you mean 'bytes'"),
            ("--limit bytes", "NAME=VALUE"),
            ("--limit bytes=many", "4G"),
            ("--limit image_side=1T", "image_side"),
            ("--crease-angle 200", "0 to 180"),
        ] {
            let said = parse(line).unwrap_err();
            assert!(said.contains(word), "{line}: {said}");
        }
    }
}
