//! Shares of the work of an exploration, as options of commands give them.

use super::{CommandFailure, output};
use clap::Args;
use robovec_explore::share::WorkShare;
use robovec_explore::store::PointStore;
use std::path::Path;

/// Share of the work to do, and the use of existing results.
#[derive(Args, Clone, Debug)]
pub(super) struct ShareArguments {
    /// Use the results that an earlier run left in the folder
    #[arg(long, requires = "output")]
    resume: bool,
    /// Do only share K of N of the work, such as 2/8, and keep the results in
    /// the folder; a last run with --resume and without --shard writes the
    /// tables
    #[arg(long, value_name = "K/N", requires = "output")]
    pub(super) shard: Option<WorkShare>,
}

impl ShareArguments {
    /// The share; all of the work where the user names none.
    pub(super) fn share(&self) -> WorkShare {
        self.shard.unwrap_or(WorkShare::ALL)
    }

    /// True when the results of an earlier run are used.
    pub(super) fn reuses(&self) -> bool {
        self.resume || self.shard.is_some()
    }

    /// Place where results are kept, if there is a folder.
    pub(super) fn store(
        &self,
        folder: Option<&Path>,
    ) -> Result<Option<PointStore>, CommandFailure> {
        let Some(folder) = folder else {
            return Ok(None);
        };
        output::make_folder(folder)?;
        let store = PointStore::open(&folder.join("points"), self.reuses());
        store.map(Some).map_err(|error| {
            CommandFailure::plain(format!("cannot make the folder for points: {error}"))
        })
    }
}
