//! The program: everything is in [`pellucid::cli`].

fn main() -> std::process::ExitCode {
    pellucid::cli::main()
}
