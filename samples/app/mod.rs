//! The application around the samples: command line, headless and window loop, output files.

mod animation;
pub mod assets;
mod bake;
mod baseline;
mod camera;
mod choices;
mod classic;
pub mod clay;
pub mod cli;
pub mod console;
mod devices;
mod drawing;
mod error_map;
mod explain;
mod exr;
pub mod files;
pub mod grid;
mod headless;
pub mod heat;
mod job;
mod light;
mod load;
pub mod offscreen;
pub mod picture;
pub mod png;
mod probe;
pub mod sample;
#[cfg(any(test, feature = "window"))]
mod spelled;
mod stats;
mod still;
mod surface;
#[cfg(test)]
pub mod testing;
mod timings;
mod walk;
#[cfg(feature = "window")]
mod window;

use std::{process::ExitCode, rc::Rc};

use clap::Parser;
use prism_engine::error::Result;
use tracing_subscriber::EnvFilter;

use cli::{Cli, Command};
use job::Job;
use sample::Sample;
use still::Still;

/// The program: what `main` does with the list of samples. Errors end here, as a line and an exit code.
pub fn main(samples: &[&dyn Sample]) -> ExitCode {
    // Wrong words end here, with clap's own message and exit code 2; so does `--help`, with 0.
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_env("PRISM_LOG").unwrap_or_else(|_| EnvFilter::new("warn,winit=error"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .init();
    match dispatch(cli.command, samples) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console::error(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

fn dispatch(command: Command, samples: &[&dyn Sample]) -> Result<()> {
    match command {
        Command::List => devices::list_samples(samples),
        Command::Devices => devices::list(),
        Command::Run(args) => {
            let job = Rc::new(Job::run(args, samples)?);
            if job.window {
                #[cfg(feature = "window")]
                return window::run(job, samples);
            }
            headless::run(&job)
        }
        Command::Render(args) => {
            let still = Still(args.scene.clone());
            headless::run(&Rc::new(Job::render(args, &still)?))
        }
        Command::Explain(args) => {
            let still = Still(args.what.clone());
            explain::run(&args, &Job::explain(&args, samples, &still)?)
        }
        Command::Bake(args) => bake::run(&args),
        Command::Probe(args) => probe::run(&args),
        Command::Bench(args) => crate::bench::run(&args),
        #[cfg(feature = "report")]
        Command::Report(args) => crate::report::run(&args),
    }
}
