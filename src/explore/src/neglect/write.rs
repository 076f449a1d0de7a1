//! The reduced scene as files: the scene, its model, its laws.

use super::search::NeglectFindings;
use robovec_model::mbs::write_mbs;

/// The files of a reduced scene, as (name, text): the scene, the model without
/// the links and external forces that are left out, and the laws that remain.
/// `stem` begins their names; `machine` is the file of the scene's machine
/// where it is no built-in one.
pub fn files(
    findings: &NeglectFindings,
    stem: &str,
    machine: Option<&str>,
) -> Vec<(String, String)> {
    let mut scene = findings.reduced.clone();
    scene.set("model", format!("{stem}.mbs"));
    if findings.rest > 0.0 {
        scene.set_motion(&format!("{stem}.laws.toml"), findings.rest);
    }
    if let Some(machine) = machine {
        scene.set("machine", machine.to_owned());
    }
    let head = "Written by robovec: a scene that leaves out what it may.";
    // The declaration of XML comes before everything else.
    let model = write_mbs(&findings.model).replacen("?>\n", &format!("?>\n<!-- {head} -->\n"), 1);
    let laws = findings.laws.to_text(&findings.model);
    vec![
        (
            format!("{stem}.scene.toml"),
            format!("# {head}\n{}", scene.text()),
        ),
        (format!("{stem}.mbs"), model),
        (format!("{stem}.laws.toml"), format!("# {head}\n{laws}")),
    ]
}
