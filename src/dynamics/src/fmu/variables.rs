//! Variables of an FMU: numbers, whose places in C are the value references.
//!
//! Names are those of the model: `q.JOINT`, `force.FORCE.x`, `m.BODY`; names
//! that are no identifiers are quoted (FMI 3.0, section 2.4.7.5.1).

use super::laws::LawParameters;
use crate::kinematics::inputs::{InputSource, element_name, source};
use hashbrown::{HashMap, HashSet};
use robovec_model::{JointKind, Model, Nature};
use std::fmt::Write;

/// Use of a variable. The letter is that of the table in the C.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum VariableRole {
    /// The independent variable.
    Time,
    /// Set by the importer.
    Input,
    /// Constant between events.
    Parameter,
    /// Position or velocity of an independent joint.
    State,
    /// Position of a dependent joint: where closing the loops starts.
    Guess,
    /// Computed.
    Output,
    /// Computed when it is read.
    Sensed,
    /// Not part of the interface.
    Hidden,
}

impl VariableRole {
    /// Its letter in the C.
    pub(super) fn letter(self) -> char {
        match self {
            VariableRole::Time => 't',
            VariableRole::Input => 'i',
            VariableRole::Parameter => 'p',
            VariableRole::State => 's',
            VariableRole::Guess => 'g',
            VariableRole::Output => 'o',
            VariableRole::Sensed => 'f',
            VariableRole::Hidden => '-',
        }
    }
}

#[derive(Clone, PartialEq, Debug)]
pub(super) struct FmuVariable {
    /// Name in the model description; empty if hidden.
    pub(super) name: String,
    pub(super) role: VariableRole,
    pub(super) unit: &'static str,
    pub(super) start: f64,
    /// The state whose derivative it is.
    pub(super) derivative_of: Option<u32>,
}

/// Place of a number: of a variable, or of its derivative along a direction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct NumberPlace {
    pub(super) slot: u32,
    pub(super) along: bool,
}

pub(super) struct FmuVariables<'m> {
    pub(super) model: &'m Model,
    pub(super) list: Vec<FmuVariable>,
    names: HashSet<String>,
    /// First place of each block, under its name in the C.
    pub(super) blocks: Vec<(&'static str, u32)>,
    parameters: HashMap<String, u32>,
    /// Laws of joints, links, forces, tyres and drives.
    pub(super) laws: LawParameters,
}

/// Components of vectors.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

impl<'m> FmuVariables<'m> {
    /// The variables before those of laws and parameters. `independent` are the
    /// joints of the state, `prescribed` driven ones with a law, from 0,
    /// ascending; `start` are positions, `rows` counts constraints.
    pub(super) fn new(
        model: &'m Model,
        independent: &[usize],
        prescribed: &[usize],
        start: &[f64],
        rows: usize,
    ) -> FmuVariables<'m> {
        let mut variables = FmuVariables {
            model,
            list: Vec::new(),
            names: HashSet::new(),
            blocks: Vec::new(),
            parameters: HashMap::new(),
            laws: LawParameters::default(),
        };
        variables.begin("AT_TIME");
        variables.add("time", VariableRole::Time, "s", 0.0);
        variables.motion(independent, prescribed, start);
        variables.loads();
        let joints = model.joints.len();
        let hidden = [
            ("AT_JOINT_FORCES", joints),
            ("AT_BODY_LOADS", 6 * joints),
            ("AT_PULLS", model.links.len()),
            ("AT_LOADS", 6 * model.forces.len()),
            ("AT_SPINS", 3 * model.forces.len()),
            ("AT_AXES", 9 * model.forces.len()),
            ("AT_MOVED", joints),
            ("AT_GAP_ROWS", rows),
        ];
        for (block, count) in hidden {
            variables.begin(block);
            for _ in 0..count {
                variables.add("", VariableRole::Hidden, "", 0.0);
            }
        }
        variables
    }

    /// Positions, velocities and accelerations of joints.
    fn motion(&mut self, independent: &[usize], prescribed: &[usize], start: &[f64]) {
        let model = self.model;
        let derivatives = ["q", "qd", "qdd"];
        let blocks = ["AT_Q", "AT_QD", "AT_QDD"];
        for (order, (word, block)) in derivatives.into_iter().zip(blocks).enumerate() {
            self.begin(block);
            for (index, joint) in model.joints.iter().enumerate() {
                let is_state = independent.binary_search(&index).is_ok();
                let moves = joint.has_velocity && joint.has_acceleration;
                let role = match (joint.nature == Nature::Driven, order) {
                    (true, _) if prescribed.binary_search(&index).is_ok() => VariableRole::Output,
                    (true, 0) if !moves => VariableRole::Parameter,
                    (true, _) if !moves => VariableRole::Hidden,
                    (true, _) => VariableRole::Input,
                    (false, 0 | 1) if is_state => VariableRole::State,
                    (false, 0) => VariableRole::Guess,
                    (false, _) => VariableRole::Output,
                };
                let number = match order {
                    0 => start[index],
                    _ if joint.nature == Nature::Driven && !moves => 0.0,
                    _ => joint.initial[order],
                };
                let unit = motion_unit(joint.kind, order);
                let slot = self.add(
                    &format!("{word}.{}", quoted(&joint.name)),
                    role,
                    unit,
                    number,
                );
                if is_state && order > 0 {
                    self.list[slot as usize].derivative_of = Some(slot - model.joints.len() as u32);
                }
            }
        }
    }

    /// Forces that the importer may add, and what a law of it would read.
    fn loads(&mut self) {
        let model = self.model;
        self.begin("AT_INPUT_FORCES");
        for joint in &model.joints {
            let role = match joint.nature {
                Nature::Driven => VariableRole::Hidden,
                _ => VariableRole::Input,
            };
            let unit = if joint.kind.is_revolute() { "N.m" } else { "N" };
            self.add(&format!("Qq.{}", quoted(&joint.name)), role, unit, 0.0);
        }
        let blocks = [
            ("AT_INPUT_PULLS", "pull", VariableRole::Input, "N"),
            ("AT_LENGTHS", "length", VariableRole::Output, "m"),
            ("AT_RATES", "rate", VariableRole::Output, "m/s"),
        ];
        for (block, word, role, unit) in blocks {
            self.begin(block);
            for link in &model.links {
                self.add(&format!("{word}.{}", quoted(&link.name)), role, unit, 0.0);
            }
        }
        self.begin("AT_INPUT_LOADS");
        for force in &model.forces {
            for (word, unit) in [("force", "N"), ("torque", "N.m")] {
                self.vector(
                    &format!("{word}.{}", quoted(&force.name)),
                    VariableRole::Input,
                    unit,
                );
            }
        }
        for (block, word, unit) in [
            ("AT_PLACES", "place", "m"),
            ("AT_VELOCITIES", "velocity", "m/s"),
        ] {
            self.begin(block);
            for force in &model.forces {
                self.vector(
                    &format!("{word}.{}", quoted(&force.name)),
                    VariableRole::Output,
                    unit,
                );
            }
        }
        self.begin("AT_SENSED");
        let sensors = model.sensors.iter().map(|sensor| &sensor.name);
        for name in sensors.chain(model.frames.iter().map(|frame| &frame.name)) {
            let name = quoted(name);
            for (word, unit) in [("place", "m"), ("velocity", "m/s"), ("spin", "rad/s")] {
                self.vector(&format!("{word}.{name}"), VariableRole::Sensed, unit);
            }
            for axis in AXES {
                self.vector(
                    &format!("rotation.{name}.{axis}"),
                    VariableRole::Sensed,
                    "1",
                );
            }
        }
        self.begin("AT_GAPS");
        for _ in &model.forces {
            self.add("", VariableRole::Hidden, "m", 0.0);
        }
    }

    fn vector(&mut self, name: &str, role: VariableRole, unit: &'static str) {
        for axis in AXES {
            self.add(&format!("{name}.{axis}"), role, unit, 0.0);
        }
    }

    fn begin(&mut self, block: &'static str) {
        self.blocks.push((block, self.list.len() as u32));
    }

    pub(super) fn block(&self, name: &str) -> u32 {
        let mut blocks = self.blocks.iter();
        let found = blocks.find(|(block, _)| *block == name);
        found.expect("a block of this name was started").1
    }

    /// Adds a variable under a name that no other has; its place.
    pub(super) fn add(
        &mut self,
        name: &str,
        role: VariableRole,
        unit: &'static str,
        start: f64,
    ) -> u32 {
        let name = match role {
            VariableRole::Hidden => String::new(),
            _ => self.unique(name),
        };
        self.list.push(FmuVariable {
            name,
            role,
            unit,
            start,
            derivative_of: None,
        });
        self.list.len() as u32 - 1
    }

    /// Gives the gap of a contact, which is hidden without one, to the importer.
    pub(super) fn show_gap(&mut self, force: usize, name: &str) {
        let name = self.unique(name);
        let slot = self.block("AT_GAPS") as usize + force;
        self.list[slot].name = name;
        self.list[slot].role = VariableRole::Output;
    }

    /// A name that no variable has, and that none gets from now on.
    fn unique(&mut self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        let found = names.find(|name| self.names.insert(name.clone()));
        found.expect("there are more numbers than names")
    }

    /// Place of an input of a generated function, `X_direction` for the
    /// derivative of `X`; parameters get one when they are first read.
    ///
    /// # Errors
    ///
    /// The name of an element that the model does not have.
    pub(super) fn input(&mut self, array: &str, indices: &[u32]) -> Result<NumberPlace, String> {
        if let Some(moved) = array.strip_suffix("_direction") {
            let NumberPlace { slot, .. } = self.input(moved, indices)?;
            return Ok(NumberPlace { slot, along: true });
        }
        let found = source(self.model, array, indices);
        let found = found.ok_or_else(|| element_name(array, indices))?;
        let at = |block: &str, index: usize| self.block(block) + index as u32;
        let slot = match found {
            InputSource::Time => at("AT_TIME", 0),
            InputSource::Position(joint) => at("AT_Q", joint),
            InputSource::Velocity(joint) => at("AT_QD", joint),
            InputSource::Acceleration(joint) => at("AT_QDD", joint),
            InputSource::JointForce(joint) => at("AT_JOINT_FORCES", joint),
            InputSource::Force(component, joint) => at("AT_BODY_LOADS", 6 * joint + component),
            InputSource::Torque(component, joint) => at("AT_BODY_LOADS", 6 * joint + 3 + component),
            InputSource::Link(link) => at("AT_PULLS", link),
            InputSource::External(force, component) if component < 6 => {
                at("AT_LOADS", 6 * force + component)
            }
            // The force acts at its point.
            InputSource::External(force, component) => {
                let point = self.model.forces[force].point as u32;
                return self.input("dpt", &[component as u32 - 5, point + 1]);
            }
            InputSource::Parameter(number) => self.parameter(array, indices, number),
        };
        Ok(NumberPlace { slot, along: false })
    }

    /// Place of an output of a generated function. `word` is the name of the
    /// array without the number at its end, `frame` the number of a sensed frame.
    ///
    /// # Panics
    ///
    /// Panics for an array that is no part of a step.
    pub(super) fn output(
        &self,
        word: &str,
        (array, frame): (&str, u32),
        indices: &[u32],
    ) -> NumberPlace {
        let number = array[word.len()..]
            .parse::<u32>()
            .map_or(0, |number| number - 1);
        let index = |place: usize| indices[place] - 1;
        let (block, offset) = match word {
            "q" => ("AT_MOVED", index(0)),
            "h" => ("AT_GAP_ROWS", index(0)),
            "qd" => ("AT_QD", index(0)),
            "qdd" => ("AT_QDD", index(0)),
            "Z" => ("AT_LENGTHS", index(0)),
            "Zd" => ("AT_RATES", index(0)),
            "frc" => ("AT_BODY_LOADS", 6 * index(1) + index(0)),
            "trq" => ("AT_BODY_LOADS", 6 * index(1) + 3 + index(0)),
            "PxF" => ("AT_PLACES", 3 * number + index(0)),
            "VxF" => ("AT_VELOCITIES", 3 * number + index(0)),
            "OMxF" => ("AT_SPINS", 3 * number + index(0)),
            "RxF" => ("AT_AXES", 9 * number + 3 * index(0) + index(1)),
            "sens.P" | "position" => ("AT_SENSED", 18 * frame + index(0)),
            "sens.V" | "velocity" => ("AT_SENSED", 18 * frame + 3 + index(0)),
            "sens.OM" | "angular_velocity" => ("AT_SENSED", 18 * frame + 6 + index(0)),
            "rotation" => ("AT_SENSED", 18 * frame + 9 + 3 * index(0) + index(1)),
            // Robotran's rotation is that into the frame.
            "sens.R" => ("AT_SENSED", 18 * frame + 9 + 3 * index(1) + index(0)),
            _ => unreachable!("'{array}' is no output of a step"),
        };
        NumberPlace {
            slot: self.block(block) + offset,
            along: false,
        }
    }

    /// Place of a parameter; both entries of a symmetric matrix share one.
    fn parameter(&mut self, array: &str, indices: &[u32], number: f64) -> u32 {
        let model = self.model;
        let joint = |index: u32| {
            let index = index as usize - 1;
            let body = model.body_of(index).map(|body| &body.name);
            quoted(body.unwrap_or(&model.joints[index].name))
        };
        let axis = |index: u32| AXES[index as usize - 1];
        let (name, unit) = match (array, indices) {
            ("dpt", &[component, point]) => {
                let point = quoted(&model.points[point as usize - 1].name);
                (format!("dpt.{point}.{}", axis(component)), "m")
            }
            ("g", &[component]) => (format!("g.{}", axis(component)), "m/s2"),
            ("m", &[index]) => (format!("m.{}", joint(index)), "kg"),
            ("l", &[component, index]) => (format!("l.{}.{}", joint(index), axis(component)), "m"),
            ("In", &[entry, index]) => {
                let (row, column) = ((entry - 1) / 3, (entry - 1) % 3);
                let (row, column) = (row.min(column), row.max(column));
                let entry = format!("{}{}", axis(row + 1), axis(column + 1));
                (format!("In.{}.{entry}", joint(index)), "kg.m2")
            }
            _ => (element_name(array, indices), "m"),
        };
        let mut key = element_name(array, indices);
        if array == "In" {
            // Names of bodies may repeat, indices do not.
            key = format!("{name} {}", indices[1]);
        }
        if let Some(&slot) = self.parameters.get(&key) {
            return slot;
        }
        let slot = self.add(&name, VariableRole::Parameter, unit, number);
        self.parameters.insert(key, slot);
        slot
    }
}

/// Unit of a position, a velocity (order 1) or an acceleration (order 2).
pub(super) fn motion_unit(kind: JointKind, order: usize) -> &'static str {
    let units = if kind.is_revolute() {
        ["rad", "rad/s", "rad/s2"]
    } else {
        ["m", "m/s", "m/s2"]
    };
    units[order]
}

/// A name as part of a structured name.
pub(super) fn quoted(name: &str) -> String {
    let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    if name.chars().all(is_word) && name.starts_with(|first: char| !first.is_ascii_digit()) {
        return name.to_owned();
    }
    let mut text = String::from("'");
    for letter in name.chars() {
        match letter {
            '\'' | '\\' => {
                text.push('\\');
                text.push(letter);
            }
            ' '..='~' => text.push(letter),
            // Only letters of ASCII are allowed.
            // Writing to a string cannot fail.
            _ => {
                let _ = write!(text, "_{:x}", u32::from(letter));
            }
        }
    }
    text.push('\'');
    text
}
