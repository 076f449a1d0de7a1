//! Files of a project, replaced and brought back.
//!
//! The originals are in the folder `.robovec` of the project, with a list of
//! the files that were added. **Invariant.** The list is written before any
//! file is replaced, so that an interrupted run can be undone.

use super::find::FoundProject;
use crate::command::{CommandFailure, output};
use robovec_io::files::{self, Replace, limited};
use robovec_ir::diagnostic::counted;
use std::path::Path;

/// Folder of the originals.
const KEPT: &str = ".robovec";

/// Name of the list: the folder, then a line for each file, `+` if added.
const LIST: &str = "replaced.txt";

pub(super) fn apply(
    project: &FoundProject,
    files: &[(String, String)],
) -> Result<(), CommandFailure> {
    let (kept, symbolic) = (project.root.join(KEPT), &project.symbolic);
    if kept.join(LIST).exists() {
        return Err(CommandFailure::advised(
            format!("{} has been replaced before", symbolic.display()),
            vec!["bring the originals back first: --undo".to_owned()],
        ));
    }
    let mut list = format!("{}\n", project.symbolic_inside().display());
    for (name, _) in files {
        let path = symbolic.join(name);
        if path.exists() {
            let bytes = limited::read(&path, &limited::EQUATIONS)?;
            write(&kept.join(name), &bytes)?;
            list += &format!("  {name}\n");
        } else {
            list += &format!("+ {name}\n");
        }
    }
    write(&kept.join(LIST), list.as_bytes())?;
    for (name, text) in files {
        write(&symbolic.join(name), text.as_bytes())?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CommandFailure> {
    if let Some(folder) = path.parent() {
        files::make_folder(folder)
            .map_err(|error| CommandFailure::plain(format!("{}: {error}", folder.display())))?;
    }
    output::write_over(path, Replace::Anything, |writer| writer.write_all(bytes))
}

/// Brings the originals back.
pub(super) fn undo(root: &Path) -> Result<String, CommandFailure> {
    let kept = root.join(KEPT);
    let list = kept.join(LIST);
    if !list.exists() {
        return Err(CommandFailure::advised(
            format!("nothing of {} was replaced", root.display()),
            vec!["--apply replaces its equations".to_owned()],
        ));
    }
    let text = robovec_io::sources::text(&list, &limited::PLAN)?;
    let mut lines = text.lines();
    let symbolic = root.join(lines.next().unwrap_or(""));
    let (mut back, mut removed) = (0, 0);
    let failed = |path: &Path, error: std::io::Error| {
        CommandFailure::plain(format!("{}: {error}", path.display()))
    };
    for line in lines {
        let Some((mark, name)) = line.split_at_checked(2) else {
            continue;
        };
        let path = symbolic.join(name);
        if mark == "+ " {
            files::remove(&path).map_err(|error| failed(&path, error))?;
            removed += 1;
        } else {
            let bytes = limited::read(&kept.join(name), &limited::EQUATIONS)?;
            write(&path, &bytes)?;
            back += 1;
        }
    }
    files::remove(&kept).map_err(|error| failed(&kept, error))?;
    Ok(format!(
        "{} brought back, {} removed\n",
        counted(back, "file"),
        counted(removed, "file")
    ))
}
