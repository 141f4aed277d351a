//! How the program fails: one line on standard error and an exit code.

use std::error::Error;

/// Exit codes, as the end of `--help` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Anything that has no code of its own.
    General = 1,
    /// The command line is wrong.
    Usage = 2,
    /// A file cannot be read or says something that is not allowed.
    Input = 3,
    /// No graphics adapter can be used.
    NoAdapter = 4,
    /// The picture differs from the reference.
    Differ = 5,
    /// The reference does not exist.
    NoReference = 6,
    /// More was asked than the adapter can do.
    Limits = 7,
}

/// A failure: its exit code and what to say.
#[derive(Debug, PartialEq)]
pub struct Failure {
    /// The code to exit with.
    pub exit: Exit,
    /// File, place and cause, in one line.
    pub message: String,
}

impl Failure {
    /// Fails with a sentence.
    pub fn new(exit: Exit, message: impl std::fmt::Display) -> Failure {
        Failure { exit, message: message.to_string() }
    }

    /// Fails with an error and whatever caused it.
    pub fn of(exit: Exit, error: &(dyn Error + 'static)) -> Failure {
        let mut message = error.to_string();
        let mut cause = error.source();
        while let Some(e) = cause {
            let text = e.to_string();
            // Some errors say their cause already.
            if !message.contains(&text) {
                message = format!("{message}: {text}");
            }
            cause = e.source();
        }
        Failure { exit, message }
    }

    /// Fails with an error about a file.
    pub fn about(exit: Exit, file: impl std::fmt::Display, error: &(dyn Error + 'static)) -> Failure {
        let Failure { message, .. } = Failure::of(exit, error);
        let file = file.to_string();
        let message = if message.starts_with(&file) { message } else { format!("{file}: {message}") };
        Failure { exit, message }
    }

    /// The message as one line that a terminal shows as it is.
    pub fn line(&self) -> String {
        let lines: Vec<&str> = self.message.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        format!("pellucid: {}", printable(&lines.join("; ")))
    }
}

/// `text` with control characters, which names in files may bring, replaced.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("outer")]
    struct Outer(#[source] std::io::Error);

    #[test]
    fn codes_are_those_that_the_help_names() {
        let all =
            [Exit::General, Exit::Usage, Exit::Input, Exit::NoAdapter, Exit::Differ, Exit::NoReference, Exit::Limits];
        assert_eq!(all.map(|e| e as u8), [1, 2, 3, 4, 5, 6, 7]);
        for (exit, word) in all.iter().zip(["else", "command line", "input", "adapter", "differ", "reference", "limit"])
        {
            let line = super::super::ENVIRONMENT.lines().find(|l| l.trim().starts_with(&format!("{} ", *exit as u8)));
            assert!(line.is_some_and(|l| l.contains(word)), "{exit:?}: {line:?}");
        }
    }

    #[test]
    fn a_failure_is_one_line_with_its_causes() {
        let e = Outer(std::io::Error::other("inner\n  detail"));
        let failure = Failure::about(Exit::Input, "a.glb", &e);
        assert_eq!(failure.line(), "pellucid: a.glb: outer: inner; detail");
        assert_eq!(Failure::about(Exit::Input, "outer", &e).line(), "pellucid: outer: inner; detail");
        assert_eq!(Failure::new(Exit::General, "x\u{1b}[31m").line(), "pellucid: x\u{fffd}[31m");
    }
}
