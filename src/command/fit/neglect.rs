//! `robovec fit --reduce`: parts that a scene need not model.

use super::FitArguments;
use crate::command::{CommandFailure, input, output, progress};
use robovec_explore::neglect::{self, NeglectError, NeglectTask};
use robovec_explore::scene::SceneSubject;
use robovec_io::files::{Replace, limited};
use robovec_io::sources::display_name;
use robovec_model::mbs::unsayable;

pub(super) fn run(arguments: &FitArguments) -> Result<String, CommandFailure> {
    let path = &arguments.scene;
    let name = display_name(path);
    let stem = name.trim_end_matches(".toml").trim_end_matches(".scene");
    let stem = format!("{stem}-reduced");
    let written = [".scene.toml", ".mbs", ".laws.toml"].map(|end| format!("{stem}{end}"));
    output::refuse_foreign(
        arguments.output.as_deref(),
        &written.each_ref().map(String::as_str),
        Replace::Results,
    )?;
    let file = input::scene(path)?;
    let source = input::text(path, &limited::SCENE)?;
    let fail = |error: NeglectError| {
        let notes = error.advice().map(str::to_owned).into_iter().collect();
        CommandFailure::advised(format!("{}: {error}", path.display()), notes)
    };
    let folder = input::folder(path);
    let module = file.module().map_err(|error| fail(error.into()))?;
    if let (SceneSubject::Model(subject), true) = (&file.subject, arguments.output.is_some())
        && let Some(reason) = unsayable(&subject.model)
    {
        return Err(CommandFailure::advised(
            format!("the reduced model would be a .mbs file, which cannot hold it: {reason}"),
            vec!["without -o the findings are printed".to_owned()],
        ));
    }
    let machine = super::machine(arguments, &file, &module)?;
    let task = NeglectTask {
        file: &file,
        name: &name,
        text: &source,
        folder,
        laws: input::laws_of(&file, folder)?,
        machine: &machine,
    };
    let bar = progress::spinner();
    let findings = neglect::neglect(&task, &|what| bar.set_message(what.to_owned()));
    bar.finish_and_clear();
    let findings = findings.map_err(fail)?;
    if let Some(folder) = &arguments.output {
        let own_machine = file.scene.machine.as_ref().filter(|name| {
            // A built-in machine goes by its name wherever the scene is.
            robovec_ir::Machine::built_in(name).is_none()
        });
        let own_machine = own_machine.map(|_| "machine.toml");
        let mut files = neglect::files(&findings, &stem, own_machine);
        if let Some(name) = own_machine {
            let machine = toml::to_string(&machine)
                .expect("a machine that was read is one that can be written");
            files.push((name.to_owned(), machine));
        }
        files.extend(neglect::report(&task, &findings));
        output::write_files(folder, &files)?;
    }
    Ok(neglect::text(&task, &findings, progress::is_verbose()))
}
