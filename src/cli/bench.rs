//! `pellucid bench`: the command line of the measurements.

use clap::{Args, Subcommand};

use super::failure::{Exit, Failure};
use super::options::size;

/// What is measured.
#[derive(Subcommand, Clone, Debug)]
pub enum BenchCommand {
    /// Neighbour search and curvature by buckets over brute force, on the paper's synthetic stack of quads
    Buckets(BucketsArgs),
    /// A whole frame of a model: unsorted blend, both captures, plain and stylized
    Frame(FrameArgs),
}

/// Options of `bench buckets`.
#[derive(Args, Clone, Debug)]
pub struct BucketsArgs {
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "512x512")]
    pub size: [u32; 2],
    /// Stacked full-screen quads
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), default_value_t = 32)]
    pub layers: u32,
    /// Interleaved runs of which the median is taken
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 7)]
    pub runs: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `bench frame`.
#[derive(Args, Clone, Debug)]
pub struct FrameArgs {
    /// A model, or builtin:NAME
    pub file: String,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1000x1000")]
    pub size: [u32; 2],
    /// Layers of the Bucketed k-Buffer
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), default_value_t = 16)]
    pub k: u32,
    /// Interleaved runs of which the median is taken
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 7)]
    pub runs: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs a measurement.
///
/// # Errors
/// Always: the measurements are not part of this build.
pub fn run(command: &BenchCommand) -> Result<(), Failure> {
    let name = match command {
        BenchCommand::Buckets(_) => "buckets",
        BenchCommand::Frame(_) => "frame",
    };
    Err(Failure::new(Exit::General, format!("bench {name}: not part of this build")))
}
