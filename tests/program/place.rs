//! The real binary in a folder of its own, with a model.

use std::path::PathBuf;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use super::support::{boxes, glb, program};

/// A folder with a model in it, `boxes.glb`: three boxes, one inside the other.
pub struct Place {
    pub folder: TempDir,
}

/// What a run of the program gave.
pub struct Run {
    pub code: Option<i32>,
    pub out: Vec<u8>,
    pub err: String,
}

impl Place {
    pub fn new() -> Place {
        let place = Place { folder: tempfile::tempdir().unwrap() };
        let (json, binary) = boxes(3);
        place.write("boxes.glb", &glb(&json, &binary));
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, data: &[u8]) {
        std::fs::write(self.path(name), data).unwrap();
    }

    /// Runs the program in the folder, with what the environment says about logs and colours left out.
    pub fn run(&self, line: &str) -> Run {
        self.run_with(line, &[])
    }

    pub fn run_with(&self, line: &str, variables: &[(&str, &str)]) -> Run {
        let mut command = program();
        command.current_dir(self.folder.path()).args(line.split_whitespace());
        for name in ["NO_COLOR", "CLICOLOR_FORCE", "CLICOLOR", "FORCE_COLOR"] {
            command.env_remove(name);
        }
        let Output { status, stdout, stderr } = command.envs(variables.iter().copied()).output().unwrap();
        Run { code: status.code(), out: stdout, err: String::from_utf8(stderr).unwrap() }
    }

    /// Runs the program, which must succeed.
    pub fn done(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, Some(0), "{line}: {}", run.err);
        run
    }

    /// The same with the words of the line, which may hold blanks.
    pub fn done_words(&self, words: &[String]) -> Run {
        let output = program().current_dir(self.folder.path()).args(words).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {err}");
        Run { code: output.status.code(), out: output.stdout, err }
    }

    /// Runs the program, which must fail with `code`, write nothing to standard output, and end with one line that has
    /// all the `words`.
    pub fn fails(&self, code: i32, line: &str, words: &[&str]) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, Some(code), "{line}: {}", run.err);
        assert!(run.out.is_empty(), "{line}: {}", String::from_utf8_lossy(&run.out));
        let last = if code == 2 { &run.err } else { run.err.lines().last().unwrap_or_default() };
        assert!(words.iter().all(|w| last.contains(w)), "{line}: {words:?} in {}", run.err);
        run
    }
}

impl Run {
    pub fn text(&self) -> String {
        String::from_utf8(self.out.clone()).unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.out).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.out)))
    }
}
