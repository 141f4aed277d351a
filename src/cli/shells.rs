//! `pellucid completions` and `pellucid man`: what a shell and a reader want to know of the command line, made from its
//! declaration, so that it cannot say anything else.

use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use super::failure::{Exit, Failure};
use super::options::Cli;
use super::output;

/// Options of `completions`.
#[derive(Args, Clone, Debug)]
pub struct CompletionsArgs {
    /// The shell that completes
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Options of `man`.
#[derive(Args, Clone, Debug)]
pub struct ManArgs {
    /// Write a page for every command into this folder, which is made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Prints what the shell is to be told.
///
/// # Errors
/// [`Exit::General`] if it cannot be written.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "pellucid", &mut script);
    output::print(&script)
}

/// Prints the program's own page, or writes the pages of all commands and prints their names.
///
/// # Errors
/// [`Exit::General`] if one cannot be written.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let pages = pages()?;
    let Some(folder) = &args.output else {
        return output::print(&pages[0].1);
    };
    std::fs::create_dir_all(folder).map_err(|e| Failure::about(Exit::General, folder.display(), &e))?;
    let mut names = String::new();
    for (name, page) in &pages {
        let path = folder.join(name);
        output::write(&path, page)?;
        names += &format!("{}\n", path.display());
    }
    output::print(names.as_bytes())
}

/// The pages of all commands by the names of their files, the program's own first.
fn pages() -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut command = Cli::command().disable_help_subcommand(true);
    // Gives commands the names of their pages, the whole line with hyphens: pellucid-bench-frame(1).
    command.build();
    let mut pages = Vec::new();
    add_pages(&command, "pellucid", &mut pages).map_err(|e| Failure::about(Exit::General, "man", &e))?;
    Ok(pages)
}

fn add_pages(command: &Command, name: &str, pages: &mut Vec<(String, Vec<u8>)>) -> std::io::Result<()> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    pages.push((format!("{name}.1"), page));
    for inner in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        add_pages(inner, &format!("{name}-{}", inner.get_name()), pages)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    fn commands() -> Vec<String> {
        let mut command = Cli::command();
        command.build();
        command.get_subcommands().map(|c| c.get_name().to_owned()).filter(|n| n != "help").collect()
    }

    #[test]
    fn completions_of_every_shell_know_every_command() {
        for shell in Shell::value_variants() {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "pellucid", &mut script);
            let script = String::from_utf8(script).unwrap();
            for name in commands() {
                assert!(script.contains(&name), "{shell}: {name}");
            }
            assert!(script.contains("camera-azimuth-angle") && script.contains("isolate"), "{shell}");
        }
    }

    #[test]
    fn there_is_a_page_for_every_command_and_the_first_names_all() {
        let pages = pages().unwrap();
        let text = |name: &str| {
            let page = pages.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("{name}"));
            String::from_utf8(page.1.clone()).unwrap().replace('\\', "")
        };
        assert_eq!(pages[0].0, "pellucid.1");
        let names = commands();
        assert!(names.len() > 15, "{names:?}");
        for name in names {
            assert!(text("pellucid.1").contains(&format!("pellucid-{name}(1)")), "{name}");
            assert!(text(&format!("pellucid-{name}.1")).contains(".SH SYNOPSIS"), "{name}");
        }
        assert!(text("pellucid-bench-frame.1").contains("--runs"));
        assert!(text("pellucid-render.1").contains("--camera-azimuth-angle"));
    }
}
