//! The scene with parts left out, as the text of a scene file.
//!
//! The scene read back from this text is measured: the one that is written.

use super::search::NeglectFindings;
use robovec_dynamics::motion::Laws;
use robovec_model::mbs::write_mbs;
use robovec_model::{Anchor, Model};
use toml::{Table, Value};

/// A scene file as a table of TOML.
#[derive(Clone, Debug)]
pub(super) struct SceneTable {
    table: Table,
    /// Its section `[motion]`, which the search does without.
    motion: Table,
}

/// Arrays of the full model's states, which scenes bind to leave parts out.
const STATE: [&str; 5] = ["q", "qd", "Qq", "frc", "trq"];

impl SceneTable {
    /// The table of a scene that was read already.
    pub(super) fn of(text: &str) -> SceneTable {
        let mut table: Table = toml::from_str(text).expect("the scene was read already");
        let motion = match table.remove("motion") {
            Some(Value::Table(motion)) => motion,
            _ => Table::new(),
        };
        table.remove("neglect");
        SceneTable { table, motion }
    }

    /// The scene without its own omissions: nothing locked, small or known.
    pub(super) fn full(&self) -> SceneTable {
        let mut full = self.clone();
        full.table.remove("locked");
        full.table.remove("small");
        if let Some(Value::Table(bound)) = full.table.get_mut("bind") {
            let stated = |key: &str| STATE.contains(&key.split('[').next().unwrap_or(key).trim());
            let keys: Vec<String> = bound.keys().filter(|key| stated(key)).cloned().collect();
            for key in keys {
                bound.remove(&key);
            }
        }
        full
    }

    pub(super) fn text(&self) -> String {
        toml::to_string(&self.table).expect("a table that was read can be written")
    }

    pub(super) fn set(&mut self, key: &str, text: String) {
        self.table.insert(key.to_owned(), Value::String(text));
    }

    /// Restores the motion of the file for the joints that still move.
    pub(super) fn set_motion(&mut self, laws: &str, error: f64) {
        let mut motion = self.motion.clone();
        motion.insert("laws".to_owned(), Value::String(laws.to_owned()));
        motion.insert("error".to_owned(), Value::Float(error));
        let locked = self.table.get("locked").and_then(Value::as_table);
        if let (Some(Value::Table(start)), Some(locked)) = (motion.get_mut("start"), locked) {
            start.retain(|name, _| !locked.contains_key(name));
        }
        self.table.insert("motion".to_owned(), Value::Table(motion));
    }

    fn section(&mut self, key: &str) -> &mut Table {
        let empty = || Value::Table(Table::new());
        let section = self.table.entry(key.to_owned()).or_insert_with(empty);
        section.as_table_mut().expect("sections are tables")
    }

    /// Locks a joint and removes the entries about its motion.
    pub(super) fn lock(&mut self, model: &Model, joint: usize, position: f64) {
        let name = model.joints[joint].name.clone();
        for array in ["q", "qd", "qdd"] {
            self.forget(array, &[&name, &(joint + 1).to_string()]);
        }
        self.section("locked").insert(name, Value::Float(position));
    }

    /// Lists a joint among those with small angles.
    pub(super) fn small(&mut self, model: &Model, joint: usize) {
        let name = Value::String(model.joints[joint].name.clone());
        let empty = || Value::Array(Vec::new());
        let list = self.table.entry("small".to_owned()).or_insert_with(empty);
        match list {
            Value::Array(list) if !list.contains(&name) => list.push(name),
            Value::Array(_) => {}
            // A single name may stand without a list.
            single => *single = Value::Array(vec![single.clone(), name]),
        }
    }

    /// Binds the elements of a joint, by its `names`, in an array to zero.
    pub(super) fn clear(&mut self, array: &str, matrix: bool, joint: usize, names: &[&str]) {
        let number = (joint + 1).to_string();
        let words: Vec<&str> = names.iter().copied().chain([number.as_str()]).collect();
        self.forget(array, &words);
        let key = if matrix {
            format!("{array}[*,{number}]")
        } else {
            format!("{array}[{number}]")
        };
        self.section("bind").insert(key, Value::Float(0.0));
    }

    /// Binds the elements of an array that belong to a body to zero.
    pub(super) fn clear_body(&mut self, array: &str, matrix: bool, model: &Model, body: usize) {
        let joint = model.bodies[body].joints.end - 1;
        let names = [&*model.joints[joint].name, &*model.bodies[body].name];
        self.clear(array, matrix, joint, &names);
    }

    pub(super) fn clear_all(&mut self, array: &str) {
        let bound = self.section("bind");
        bound.retain(|key, _| key.split('[').next().map(str::trim) != Some(array));
        bound.insert(array.to_owned(), Value::Float(0.0));
    }

    /// Removes the entries about elements that these words name.
    fn forget(&mut self, array: &str, words: &[&str]) {
        for section in ["bind", "range"] {
            let Some(Value::Table(section)) = self.table.get_mut(section) else {
                continue;
            };
            if let Some(Value::Table(exceptions)) = section.get_mut(array) {
                exceptions.retain(|word, _| !words.contains(&word));
            }
            section.retain(|key, _| {
                let Some((name, indices)) = key.split_once('[') else {
                    return true;
                };
                let last = indices.trim_end_matches(']').rsplit(',').next();
                name.trim() != array || !last.is_some_and(|last| words.contains(&last.trim()))
            });
        }
    }

    /// Binds to zero the forces that no law gives: those of joints without a
    /// law and of bodies that neither a link nor an external force acts on.
    /// That is no omission: under these laws they are zero.
    pub(super) fn clear_loads(&mut self, model: &Model, laws: &Laws) {
        let ends = |list: &[Anchor]| list.iter().filter_map(|end| end.body).collect::<Vec<_>>();
        let mut loaded = vec![false; model.bodies.len()];
        for (link, law) in model.links.iter().zip(&laws.links) {
            if law.acts() {
                ends(&link.ends)
                    .into_iter()
                    .for_each(|body| loaded[body] = true);
            }
        }
        for (force, law) in model.forces.iter().zip(&laws.forces) {
            let body = model.points[force.point].body;
            if let Some(body) = body.filter(|_| law.acts()) {
                loaded[body] = true;
            }
        }
        for (joint, law) in laws.joints.iter().enumerate() {
            if !law.acts() {
                self.clear("Qq", false, joint, &[&model.joints[joint].name]);
            }
        }
        for (body, _) in loaded.iter().enumerate().filter(|(_, loaded)| !**loaded) {
            self.clear_body("frc", true, model, body);
            self.clear_body("trq", true, model, body);
        }
    }
}

/// The files of a reduced scene, as (name, text): the scene, the model without
/// omitted links and forces, and the laws left. `stem` begins their names;
/// `machine` is the file of a machine that is not built in.
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
