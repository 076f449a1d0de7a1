//! The arrays that a scene can name, and names of the items they count.

use super::document::WordProblem;
use robovec_framework::scene::{ElementPattern, IndexPattern};
use robovec_ir::diagnostic::{clip, suggestion};
use robovec_ir::{Module, Shape};
use robovec_model::{CutKind, Model};

/// An array with the meaning of its indices.
pub(super) struct KnownArray {
    pub(super) name: String,
    pub(super) shape: Shape,
    /// Index into [`SceneArrays::names`] of the items of the last index.
    counts: Option<usize>,
}

/// Indices of a kind: the word for it, and names with their numbers from 1.
struct IndexNames {
    what: &'static str,
    list: Vec<(String, u32)>,
}

/// The input arrays that a scene can speak of.
pub(super) struct SceneArrays {
    pub(super) list: Vec<KnownArray>,
    names: Vec<IndexNames>,
    /// Number of joints, where there is a model.
    joints: Option<u32>,
}

/// [`SceneArrays::names`] of joints, points and rods.
const JOINTS: usize = 0;
const POINTS: usize = 1;
const RODS: usize = 2;

impl SceneArrays {
    /// Those of a model's functions.
    pub(super) fn of_model(model: &Model) -> SceneArrays {
        let joints = model.joints.len() as u32;
        let rods = rods(model);
        let vector = |name: &str, length, counts| (name.to_owned(), Shape::Vector(length), counts);
        let matrix = |name: &str, rows, columns, counts| {
            (name.to_owned(), Shape::Matrix(rows, columns), Some(counts))
        };
        let mut list = vec![("tsim".to_owned(), Shape::Scalar, None)];
        for name in ["q", "qd", "qdd", "Qq", "m"] {
            list.push(vector(name, joints, Some(JOINTS)));
        }
        for name in ["frc", "trq", "l"] {
            list.push(matrix(name, 3, joints, JOINTS));
        }
        list.push(matrix("In", 9, joints, JOINTS));
        list.push(matrix("dpt", 3, model.points.len() as u32, POINTS));
        list.push(vector("g", 3, None));
        list.push(vector("lrod", rods.len() as u32, Some(RODS)));
        for link in 1..=model.links.len() {
            list.push((format!("Flink{link}"), Shape::Scalar, None));
        }
        for force in 1..=model.forces.len() {
            list.push(vector(&format!("SWr{force}"), 9, None));
        }
        let list = list
            .into_iter()
            .map(|(name, shape, counts)| KnownArray {
                name,
                shape,
                counts,
            })
            .collect();
        let named = |what, list| IndexNames { what, list };
        SceneArrays {
            list,
            names: vec![
                named("joint", joint_names(model)),
                named("point", point_names(model)),
                named("rod", rods),
            ],
            joints: Some(joints),
        }
    }

    /// The input arrays of functions that were read.
    pub(super) fn of_module(module: &Module) -> SceneArrays {
        let mut list: Vec<KnownArray> = Vec::new();
        let inputs = module.functions.iter().flat_map(|f| f.inputs());
        for array in inputs {
            let name = module.tables.symbols.text(array.name);
            if list.iter().all(|known| known.name != name) {
                list.push(KnownArray {
                    name: name.to_owned(),
                    shape: array.shape,
                    counts: None,
                });
            }
        }
        SceneArrays {
            list,
            names: Vec::new(),
            joints: None,
        }
    }

    fn find(&self, name: &str) -> Result<usize, WordProblem> {
        let found = self.list.iter().position(|array| array.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = self.list.iter().map(|array| array.name.as_str()).collect();
            WordProblem::unknown("there is no input array", name, &names)
        })
    }

    /// Number of the item of an array's last index, by name or number.
    pub(super) fn last_index(&self, array: usize, word: &str) -> Result<u32, WordProblem> {
        let array = &self.list[array];
        let extent = match array.shape {
            Shape::Scalar => return Err(format!("'{}' is a single number", array.name).into()),
            Shape::Vector(extent) | Shape::Matrix(_, extent) => extent,
        };
        match self.index(word, extent, array.counts)? {
            IndexPattern::Between(first, last) if first == last => Ok(first),
            _ => Err("one name or number is expected here".to_owned().into()),
        }
    }

    /// The number of a joint, by name or number.
    pub(super) fn joint(&self, word: &str) -> Result<u32, WordProblem> {
        let array = self.list.iter().position(|array| array.name == "q");
        let message = "the functions read no joint positions 'q'";
        self.last_index(array.ok_or(message.to_owned())?, word)
    }

    pub(super) fn joint_name(&self, number: u32) -> String {
        let names = self.names.get(JOINTS).map_or(&[][..], |names| &names.list);
        let found = names.iter().find(|(_, joint)| *joint == number);
        found.map_or_else(|| number.to_string(), |(name, _)| name.clone())
    }

    /// Reads a pattern of elements of an input array.
    pub(super) fn pattern(&self, text: &str) -> Result<(usize, ElementPattern), WordProblem> {
        let (name, indices) = split(text)?;
        let array = self.find(name)?;
        let known = &self.list[array];
        let pattern = self.indices(name, known.shape, known.counts, indices)?;
        Ok((array, pattern))
    }

    /// Reads a pattern of elements of an output array, by joints if it can.
    pub(super) fn output_pattern(
        &self,
        outputs: &[(String, Shape)],
        text: &str,
    ) -> Result<ElementPattern, WordProblem> {
        let (name, indices) = split(text)?;
        let Some((_, shape)) = outputs.iter().find(|(output, _)| output == name) else {
            let names: Vec<&str> = outputs.iter().map(|(name, _)| name.as_str()).collect();
            return Err(WordProblem::unknown(
                "there is no output array",
                name,
                &names,
            ));
        };
        self.indices(name, *shape, None, indices)
    }

    /// The indices of a pattern; a joint's name means its number.
    fn indices(
        &self,
        name: &str,
        shape: Shape,
        counts: Option<usize>,
        words: Option<&str>,
    ) -> Result<ElementPattern, WordProblem> {
        let mut pattern = ElementPattern::whole(name);
        let Some(words) = words else {
            return Ok(pattern);
        };
        let extents = match shape {
            Shape::Scalar => Vec::new(),
            Shape::Vector(extent) => vec![extent],
            Shape::Matrix(rows, columns) => vec![rows, columns],
        };
        let words: Vec<&str> = words.split(',').map(str::trim).collect();
        if words.len() != extents.len() {
            let wanted = match extents.len() {
                0 => "no index".to_owned(),
                1 => "one index".to_owned(),
                count => format!("{count} indices"),
            };
            let message = format!("'{}' has {wanted}, not {}", clip(name), words.len());
            return Err(message.into());
        }
        for (place, (word, &extent)) in words.iter().zip(&extents).enumerate() {
            let last = place + 1 == extents.len();
            let of_joints = (self.joints == Some(extent)).then_some(JOINTS);
            let counts = counts.filter(|_| last).or(of_joints);
            pattern.indices.push(self.index(word, extent, counts)?);
        }
        Ok(pattern)
    }

    /// One index: `*`, a number, `first..last`, or a name.
    fn index(
        &self,
        word: &str,
        extent: u32,
        counts: Option<usize>,
    ) -> Result<IndexPattern, WordProblem> {
        if word == "*" {
            return Ok(IndexPattern::Any);
        }
        let number = |word: &str| -> Result<u32, WordProblem> {
            if let Ok(number) = word.parse::<u32>() {
                let within = (1..=extent).contains(&number);
                let message = format!("the index {number} is not from 1 to {extent}");
                return within.then_some(number).ok_or(message.into());
            }
            self.named(word, counts)
        };
        if let Some((first, last)) = word.split_once("..") {
            let (first, last) = (number(first.trim())?, number(last.trim())?);
            if first > last {
                let message = format!("'{word}' goes from a larger to a smaller index");
                return Err(message.into());
            }
            return Ok(IndexPattern::Between(first, last));
        }
        number(word).map(|index| IndexPattern::Between(index, index))
    }

    fn named(&self, word: &str, counts: Option<usize>) -> Result<u32, WordProblem> {
        let names = counts.and_then(|counts| self.names.get(counts));
        let Some(names) = names else {
            let message = format!(
                "'{}' is not an index: expected a number from 1, 'a..b' or '*'",
                clip(word)
            );
            return Err(message.into());
        };
        let found = names.list.iter().find(|(name, _)| name == word);
        found.map(|&(_, number)| number).ok_or_else(|| {
            let near = suggestion(word, names.list.iter().map(|(name, _)| name.as_str()));
            WordProblem {
                message: format!("the model has no {} '{}'", names.what, clip(word)),
                notes: near.into_iter().collect(),
            }
        })
    }
}

/// The array and the text between the brackets of a pattern.
fn split(text: &str) -> Result<(&str, Option<&str>), WordProblem> {
    let Some((name, rest)) = text.split_once('[') else {
        return Ok((text.trim(), None));
    };
    let indices = rest.trim_end().strip_suffix(']');
    let message = "the bracket '[' is not closed by a last ']'";
    Ok((name.trim(), Some(indices.ok_or(message.to_owned())?)))
}

/// Joints by name; the name of a body means its last joint, which moves it.
fn joint_names(model: &Model) -> Vec<(String, u32)> {
    let mut names: Vec<(String, u32)> = Vec::new();
    for (index, joint) in model.joints.iter().enumerate() {
        names.push((joint.name.clone(), index as u32 + 1));
    }
    for body in &model.bodies {
        if names.iter().all(|(name, _)| *name != body.name) {
            names.push((body.name.clone(), body.joints.end as u32));
        }
    }
    names
}

/// Points as `body.point`, `base.point` or, for unique names, the name alone.
fn point_names(model: &Model) -> Vec<(String, u32)> {
    let mut names = Vec::new();
    for (index, point) in model.points.iter().enumerate() {
        let number = index as u32 + 1;
        let body = point
            .body
            .map_or("base", |body| model.bodies[body].name.as_str());
        names.push((format!("{body}.{}", point.name), number));
        let bearers = model.points.iter().filter(|other| other.name == point.name);
        if bearers.count() == 1 {
            names.push((point.name.clone(), number));
        }
    }
    names
}

fn rods(model: &Model) -> Vec<(String, u32)> {
    let rods = model
        .cuts
        .iter()
        .filter(|cut| matches!(cut.kind, CutKind::Rod(_)));
    rods.zip(1..)
        .map(|(cut, number)| (cut.name.clone(), number))
        .collect()
}
