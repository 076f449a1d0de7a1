//! `robovec scene`: what a scene means.

use super::Failure;
use crate::scene::SceneFile;
use clap::Args;
use robovec_ir::diagnostic::termcolor::ColorChoice;
use std::path::PathBuf;

/// Which scene.
#[derive(Args, Debug)]
pub(super) struct SceneArguments {
    /// Scene (.scene.toml)
    scene: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &SceneArguments) -> Result<String, Failure> {
    let file = SceneFile::load(&arguments.scene).map_err(Failure)?;
    file.warnings
        .emit_to_stderr(ColorChoice::Auto)
        .unwrap_or_default();
    Ok(format!("{:#?}\n", file.scene))
}
