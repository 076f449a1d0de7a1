//! The model and build descriptions of an FMU (FMI 3.0, 2.4 and 2.5.1.4.1).

use super::FmuPlan;
use super::variables::{FmuVariable, FmuVariables, VariableRole};
use robovec_present::escape::Escaped;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Units of variables, as powers of kg, m, s and rad.
const UNITS: [(&str, [i8; 4]); 16] = [
    ("s", [0, 0, 1, 0]),
    ("m", [0, 1, 0, 0]),
    ("m/s", [0, 1, -1, 0]),
    ("m/s2", [0, 1, -2, 0]),
    ("rad", [0, 0, 0, 1]),
    ("rad/s", [0, 0, -1, 1]),
    ("rad/s2", [0, 0, -2, 1]),
    ("N", [1, 1, -2, 0]),
    ("N.m", [1, 2, -2, 0]),
    ("N/m", [1, 0, -2, 0]),
    ("N.s/m", [1, 0, -1, 0]),
    ("N.m/rad", [1, 2, -2, -1]),
    ("N.m.s/rad", [1, 2, -1, -1]),
    ("kg", [1, 0, 0, 0]),
    ("kg.m2", [1, 2, 0, 0]),
    ("1", [0, 0, 0, 0]),
];

pub(super) fn description(
    plan: &FmuPlan,
    variables: &FmuVariables<'_>,
    (identifier, token): (&str, &str),
) -> String {
    let model = variables.model;
    let shown = || {
        let list = variables.list.iter().enumerate();
        list.filter(|(_, variable)| variable.role != VariableRole::Hidden)
    };
    let capabilities = "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" \
                        providesDirectionalDerivatives=\"true\"";
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" \
         instantiationToken=\"{token}\"\n  generationTool=\"robovec\" \
         variableNamingConvention=\"structured\">\n\
         \x20 <ModelExchange modelIdentifier=\"{identifier}\" {capabilities}\n\
         \x20   needsCompletedIntegratorStep=\"true\"/>\n\
         \x20 <CoSimulation modelIdentifier=\"{identifier}\" {capabilities}\n\
         \x20   canHandleVariableCommunicationStepSize=\"true\"/>\n\
         \x20 <UnitDefinitions>\n",
        name = Escaped(&printable(&model.name)),
    );
    let units: BTreeSet<&str> = shown().map(|(_, variable)| variable.unit).collect();
    for (unit, powers) in UNITS.iter().filter(|(unit, _)| units.contains(unit)) {
        let names = ["kg", "m", "s", "rad"].into_iter().zip(powers);
        let powers = names.filter(|(_, power)| **power != 0);
        let powers = powers.map(|(name, power)| format!(" {name}=\"{power}\""));
        let base: String = powers.collect();
        add(
            &mut text,
            &format!("    <Unit name=\"{unit}\"><BaseUnit{base}/></Unit>"),
        );
    }
    text += "  </UnitDefinitions>\n\
             \x20 <LogCategories>\n\
             \x20   <Category name=\"logStatusDiscard\"/>\n\
             \x20   <Category name=\"logStatusError\"/>\n\
             \x20 </LogCategories>\n\
             \x20 <DefaultExperiment startTime=\"0\" stopTime=\"1\" tolerance=\"1e-8\"/>\n\
             \x20 <ModelVariables>\n";
    for (slot, variable) in shown() {
        add(
            &mut text,
            &format!("    <Float64 {}/>", attributes(slot, variable)),
        );
    }
    text += "  </ModelVariables>\n  <ModelStructure>\n";
    structure(&mut text, plan, variables);
    text += "  </ModelStructure>\n</fmiModelDescription>\n";
    text
}

fn add(text: &mut String, line: &str) {
    text.push_str(line);
    text.push('\n');
}

fn attributes(slot: usize, variable: &FmuVariable) -> String {
    let start = format!("start=\"{:?}\"", variable.start);
    let (kind, start) = match variable.role {
        VariableRole::Time => ("causality=\"independent\" variability=\"continuous\"", None),
        VariableRole::Input => ("causality=\"input\"", Some(start)),
        VariableRole::Parameter => {
            let kind = "causality=\"parameter\" variability=\"tunable\" initial=\"exact\"";
            (kind, Some(start))
        }
        VariableRole::State => ("causality=\"output\" initial=\"exact\"", Some(start)),
        VariableRole::Guess => ("causality=\"output\" initial=\"approx\"", Some(start)),
        VariableRole::Output | VariableRole::Sensed | VariableRole::Hidden => {
            ("causality=\"output\"", None)
        }
    };
    let mut text = format!(
        "name=\"{}\" valueReference=\"{slot}\" {kind} unit=\"{}\"",
        Escaped(&variable.name),
        variable.unit,
    );
    if let Some(state) = variable.derivative_of {
        // Writing to a string cannot fail.
        let _ = write!(text, " derivative=\"{state}\"");
    }
    match start {
        Some(start) => format!("{text} {start}"),
        None => text,
    }
}

/// Outputs, derivatives of states, unknowns of the start, and events.
fn structure(text: &mut String, plan: &FmuPlan, variables: &FmuVariables<'_>) {
    let mut list = |element: &str, slot: u32| {
        add(text, &format!("    <{element} valueReference=\"{slot}\"/>"));
    };
    let roles = || {
        variables
            .list
            .iter()
            .zip(0..)
            .map(|(variable, slot)| (variable.role, slot))
    };
    let computed = |role| {
        matches!(
            role,
            VariableRole::Guess | VariableRole::Output | VariableRole::Sensed
        )
    };
    for (role, slot) in roles() {
        if computed(role) || role == VariableRole::State {
            list("Output", slot);
        }
    }
    for block in ["AT_QD", "AT_QDD"] {
        for &joint in &plan.independent {
            list(
                "ContinuousStateDerivative",
                variables.block(block) + joint as u32,
            );
        }
    }
    for (role, slot) in roles() {
        if computed(role) {
            list("InitialUnknown", slot);
        }
    }
    for event in &plan.watched {
        list("EventIndicator", event.slot);
    }
}

pub(super) fn build_description(identifier: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiBuildDescription fmiVersion=\"3.0\">\n\
         \x20 <BuildConfiguration modelIdentifier=\"{identifier}\">\n\
         \x20   <SourceFileSet language=\"C99\">\n\
         \x20     <SourceFile name=\"{identifier}.c\"/>\n\
         \x20   </SourceFileSet>\n\
         \x20 </BuildConfiguration>\n\
         </fmiBuildDescription>\n"
    )
}

/// A name without control characters, which XML does not allow.
fn printable(name: &str) -> String {
    name.chars().filter(|letter| !letter.is_control()).collect()
}
