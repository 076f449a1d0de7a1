//! What a placement depends on.

use super::plan::{NamedMachine, NamedPipeline, PlacementRequest};
use crate::explore::store::PointKey;

/// The key of a placement, given that of the equations.
pub fn key(
    equations: PointKey,
    build: PointKey,
    pipeline: &NamedPipeline,
    machine: &NamedMachine,
    request: &PlacementRequest,
) -> PointKey {
    let machine = serde_json::to_string(&machine.machine).expect("a machine is plain data");
    equations
        .with(&build.file_name())
        .with(&pipeline.pipeline.to_string())
        .with(&machine)
        .with(&format!("{}+{}", request.n_add, request.n_multi))
        .with(&format!("{:?} {:?}", request.priority, request.choice))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::{ChoiceKey, PriorityKey};
    use robovec_ir::{Format, Machine};
    use robovec_passes::registry::REGISTRY;

    /// Keys of equations and build, pipeline, machine and request.
    type All = (
        PointKey,
        PointKey,
        NamedPipeline,
        NamedMachine,
        PlacementRequest,
    );

    fn example() -> All {
        let pipeline = NamedPipeline {
            name: "usual".to_owned(),
            pipeline: REGISTRY.pipeline("atomise,cse,place").expect("a pipeline"),
            printed: None,
        };
        let machine = NamedMachine {
            name: "thesis".to_owned(),
            machine: Machine::built_in("thesis").expect("it ships"),
            couple: None,
        };
        let request = PlacementRequest {
            model: 0,
            pipeline: 0,
            machine: 0,
            n_add: 4,
            n_multi: 4,
            priority: PriorityKey::Best,
            choice: ChoiceKey::Preferential,
        };
        let equations = PointKey::new().with("function f equations {}");
        let build = PointKey::new().with("build");
        (equations, build, pipeline, machine, request)
    }

    #[test]
    fn a_key_depends_on_everything_a_point_depends_on() {
        type Change = fn(&mut All);
        let changes: [(&str, Change); 12] = [
            ("nothing", |_| {}),
            ("equations", |all| all.0 = all.0.with("another")),
            ("build", |all| all.1 = all.1.with("another")),
            ("pipeline", |all| {
                all.2.pipeline = REGISTRY.pipeline("atomise,place").expect("a pipeline");
            }),
            ("stages", |all| all.3.machine.elements[0].stages += 1),
            ("words", |all| all.3.machine.memory.words = Some(77)),
            ("number", |all| all.3.machine.number = Format::BINARY64),
            ("adders", |all| all.4.n_add += 1),
            ("multipliers", |all| all.4.n_multi += 1),
            ("priority", |all| all.4.priority = PriorityKey::Alap),
            ("another", |all| all.4.priority = PriorityKey::FanOut),
            ("choice", |all| all.4.choice = ChoiceKey::First),
        ];
        let mut keys = Vec::new();
        for (what, change) in changes {
            let mut all = example();
            change(&mut all);
            let key = key(all.0, all.1, &all.2, &all.3, &all.4);
            assert!(!keys.contains(&key), "{what}");
            keys.push(key);
        }
        // Two numbers that stand side by side are not taken for others.
        let mut all = example();
        (all.4.n_add, all.4.n_multi) = (1, 12);
        let one = key(all.0, all.1, &all.2, &all.3, &all.4);
        (all.4.n_add, all.4.n_multi) = (11, 2);
        assert_ne!(one, key(all.0, all.1, &all.2, &all.3, &all.4));
    }
}
