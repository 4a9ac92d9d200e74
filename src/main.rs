//! The `swellcast` program: reads the command line and hands over.

fn main() -> std::process::ExitCode {
    swellcast::cli::main()
}
