//! Effect of series for sines and cosines on the results of a model.
//!
//! [`measure`] replaces the sines and cosines of a function by polynomials, for
//! several orders and ranges of the joints, and compares the outputs with those
//! of true sines and cosines at random states. The error of a series reaches
//! every output, and mostly far above rounding (thesis 1.2.2, remark); a table
//! shows where one takes over.

use crate::captions;
use crate::program::{ExplorationError, transformed};
use robovec_analysis::critical_path::critical_path;
use robovec_dynamics::kinematics::{InputSources, MotionState};
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_framework::manager::RunError;
use robovec_framework::options::OptionValue;
use robovec_ir::states::{Ranges, States};
use robovec_ir::{Format, Input, Machine, Module, View};
use robovec_model::Model;
use robovec_num::soft_float::FormatArithmetic;
use robovec_passes::registry::REGISTRY;
use robovec_passes::trigonometry::{AngleOption, CircularMethod, Trigonometry};
use robovec_present::number::exponential;
use robovec_present::{
    AxisScale, CellValue, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
    text_lines,
};
use std::sync::Arc;

/// Settings of the measurement.
#[derive(Clone, Debug)]
pub struct TrigonometrySetting {
    /// Way in which sines and cosines are computed.
    pub method: CircularMethod,
    /// Orders of the polynomials.
    pub orders: Vec<u32>,
    /// Ranges of the joints, of either sign, rad (and m, where they slide).
    pub angles: Vec<f64>,
    /// Number of times angles are halved.
    pub halvings: u32,
    /// The format the outputs are computed in.
    pub format: Format,
    /// Random states of each range.
    pub states: u32,
    /// Seed of the states.
    pub seed: u64,
}

/// The outputs of one function for one range and one way to compute sines.
#[derive(Clone, PartialEq, Debug)]
pub struct TrigonometryRow {
    /// The range of the joints.
    pub angle: f64,
    /// The order; `None` for true sines and cosines.
    pub order: Option<u32>,
    /// Proved largest errors of sine and cosine on the range.
    pub proved: [f64; 2],
    /// Operations of the function, and its longest path in cycles.
    pub size: [u32; 2],
    /// Per output array the largest error over the largest element in a state.
    pub errors: Vec<ErrorSpread>,
}

/// All rows of one function.
#[derive(Clone, PartialEq, Debug)]
pub struct TrigonometryEffect {
    /// The function, or the model and the function.
    pub name: String,
    /// Names of its output arrays.
    pub arrays: Vec<String>,
    /// One row for every range and order.
    pub rows: Vec<TrigonometryRow>,
}

/// Measures every function of a module. Parameters are those of the model
/// when there is one, else random ones; so are velocities and forces.
///
/// # Errors
///
/// Fails when a pass fails, or the equations are not the model's.
pub fn measure(
    name: &str,
    module: &Module,
    model: Option<&Model>,
    machine: &Machine,
    setting: &TrigonometrySetting,
) -> Result<Vec<TrigonometryEffect>, ExplorationError> {
    let mut machine = machine.clone();
    machine.number = setting.format;
    let mut effects: Vec<TrigonometryEffect> = Vec::new();
    for function in &module.functions {
        let arrays = function.outputs().iter();
        effects.push(TrigonometryEffect {
            name: match module.functions.len() {
                1 => name.to_owned(),
                _ => format!("{name} {}", function.name),
            },
            arrays: arrays
                .map(|array| module.tables.symbols.text(array.name).to_owned())
                .collect(),
            rows: Vec::new(),
        });
    }
    for &angle in &setting.angles {
        let exact = module
            .functions
            .iter()
            .map(|function| {
                let tables = &module.tables;
                yardstick(View { tables, function }, model, angle, setting)
            })
            .collect::<Result<Vec<Yardstick>, ExplorationError>>()?;
        let orders = std::iter::once(None).chain(setting.orders.iter().copied().map(Some));
        for order in orders {
            let replaced = match order {
                None => module.clone(),
                Some(order) => replaced(module, &machine, setting, order, angle)?,
            };
            let proved = match order {
                None => [0.0; 2],
                Some(order) => proved(&machine, setting, order, angle),
            };
            for ((effect, function), exact) in
                effects.iter_mut().zip(&replaced.functions).zip(&exact)
            {
                let view = replaced.tables.view(function);
                let path = critical_path(function, &machine).asap_cycle;
                let counts = robovec_ir::count::Counts::of(function);
                effect.rows.push(TrigonometryRow {
                    angle,
                    order,
                    proved,
                    size: [counts.operations as u32, path],
                    errors: exact.errors(view, setting.format)?.arrays,
                });
            }
        }
    }
    Ok(effects)
}

fn replaced(
    module: &Module,
    machine: &Machine,
    setting: &TrigonometrySetting,
    order: u32,
    angle: f64,
) -> Result<Module, RunError> {
    let (method, range) = (setting.method.print(), AngleOption(angle).print());
    let halvings = setting.halvings;
    let text = format!(
        "trigonometry{{method={method} order={order} range={range} halvings={halvings}}},\
         atomise,fold,cse,dce"
    );
    let pipeline = REGISTRY
        .pipeline(&text)
        .expect("made of known passes and options");
    transformed(module, &pipeline, machine, None)
}

/// Proved errors of sine and cosine; a given order always gives polynomials.
fn proved(machine: &Machine, setting: &TrigonometrySetting, order: u32, angle: f64) -> [f64; 2] {
    let pass = Trigonometry {
        method: setting.method,
        order,
        halvings: setting.halvings,
        ..Trigonometry::default()
    };
    let found = pass.polynomials(machine, angle);
    found.map_or([f64::INFINITY; 2], |(_, errors)| errors)
}

/// The exact outputs at random states, from the numbers of the format.
fn yardstick(
    view: View<'_>,
    model: Option<&Model>,
    angle: f64,
    setting: &TrigonometrySetting,
) -> Result<Yardstick, ExplorationError> {
    let ranges = ranges(view, model, angle)?;
    let source = States::new(setting.seed).within(Arc::new(ranges));
    let arithmetic = FormatArithmetic::new(setting.format);
    let state = |index| {
        let state = source.draw(view, index).into_iter();
        state.map(|number| arithmetic.convert(number)).collect()
    };
    let states = (0..setting.states.max(1)).map(state).collect();
    Ok(Yardstick::at(view, states))
}

/// Joints within the range, parameters from the model.
fn ranges(view: View<'_>, model: Option<&Model>, angle: f64) -> Result<Ranges, ExplorationError> {
    let mut ranges = Ranges::default();
    let parameters = match model {
        None => None,
        Some(model) => {
            let inputs = InputSources::new(model, view).map_err(ExplorationError::Input)?;
            Some(inputs.gather(&MotionState::initial(model)))
        }
    };
    for index in 0..view.function.input_len() {
        let (array, indices, _) = view.function.input_element(Input(index as u32));
        let name = view.tables.symbols.text(array.name);
        match (name, &parameters) {
            ("q", _) => ranges.set(name, indices, -angle, angle),
            ("dpt" | "l" | "m" | "In" | "g" | "lrod", Some(parameters)) => {
                ranges.set(name, indices, parameters[index], parameters[index]);
            }
            _ => {}
        }
    }
    Ok(ranges)
}

/// The rows of one function, for users.
pub fn text(effect: &TrigonometryEffect) -> String {
    let mut head =
        "angles ± | order | >error of sin | >error of cos | >operations | >path".to_owned();
    for array in &effect.arrays {
        head += &format!(" | >{array}: median | >{array}: worst");
    }
    let rows: Vec<Vec<String>> = effect.rows.iter().map(cells).collect();
    format!("{}:\n{}", effect.name, text_lines(&head, &rows))
}

fn cells(row: &TrigonometryRow) -> Vec<String> {
    let mut cells = vec![row.angle.to_string()];
    match row.order {
        None => cells.extend(["true".to_owned(), String::new(), String::new()]),
        Some(order) => {
            cells.push(order.to_string());
            cells.extend(row.proved.map(exponential));
        }
    }
    cells.extend(row.size.map(|number| number.to_string()));
    for errors in &row.errors {
        cells.extend([exponential(errors.median), exponential(errors.worst)]);
    }
    cells
}

/// The same as a table for programs: one row for every output array.
pub fn table(effects: &[TrigonometryEffect]) -> DataTable {
    type Row<'a> = (&'a TrigonometryEffect, &'a TrigonometryRow, usize);
    let order = |row: &Row<'_>| match row.1.order {
        None => CellValue::Text("true".to_owned()),
        Some(order) => CellValue::Count(order.into()),
    };
    let columns = columns! { Row<'_>;
        "function", [Hidden, All], |row| row.0.name.as_str();
        "range (rad)", [Hidden, All], |row| row.1.angle;
        "order", [Hidden, All], order;
        "largest error of sin", [Hidden, All], |row| row.1.proved[0];
        "largest error of cos", [Hidden, All], |row| row.1.proved[1];
        "operations", [Hidden, All], |row| row.1.size[0];
        "path (cycles)", [Hidden, All], |row| row.1.size[1];
        "array", [Hidden, All], |row| row.0.arrays[row.2].as_str();
        "normwise error, median", [Hidden, All], |row| row.1.errors[row.2].median;
        "normwise error, worst", [Hidden, All], |row| row.1.errors[row.2].worst;
    };
    let mut rows: Vec<Row<'_>> = Vec::new();
    for effect in effects {
        for row in &effect.rows {
            rows.extend((0..effect.arrays.len()).map(|array| (effect, row, array)));
        }
    }
    captions::table("trig", &[], &columns, &rows)
}

/// Median errors against the range, one curve for every order.
pub fn figure(effects: &[TrigonometryEffect]) -> Figure {
    let mut panels = Vec::new();
    for effect in effects {
        for (index, array) in effect.arrays.iter().enumerate() {
            panels.push(Panel::curves(
                format!("{} {array}", effect.name),
                PlotAxis::new("range of the joints (rad)", AxisScale::Decades),
                PlotAxis::new("median normwise error", AxisScale::Decades),
                curves(effect, index),
            ));
        }
    }
    captions::figure("trig", "trig", &[], panels).expect("a function has outputs")
}

fn curves(effect: &TrigonometryEffect, array: usize) -> Vec<Curve> {
    let mut orders: Vec<Option<u32>> = effect.rows.iter().map(|row| row.order).collect();
    orders.sort_unstable();
    orders.dedup();
    let marks = |order: Option<u32>| {
        let rows = effect.rows.iter().filter(move |row| row.order == order);
        let marks = rows.map(|row| Mark::at(row.angle, row.errors[array].median));
        // A logarithm has no place for nothing.
        marks.filter(|mark| mark.y > 0.0)
    };
    orders
        .into_iter()
        .enumerate()
        .map(|(place, order)| {
            Curve::new(
                match order {
                    None => "true".to_owned(),
                    Some(order) => format!("order {order}"),
                },
                Paint::Distinct(place),
                Stroke::Marked,
                marks(order),
            )
        })
        .collect()
}
