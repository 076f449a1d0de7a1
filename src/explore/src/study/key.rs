//! The key under which the store keeps a placement of a study: a hash of all
//! that the placement depends on, and of nothing else.

use super::plan::{NamedMachine, NamedPipeline, PlacementRequest};
use crate::store::PointKey;

/// The key of a placement, given the keys of its equations and of the build of
/// robovec ([`build_key`](crate::store::build_key)).
///
/// Of `pipeline` and `machine` the names are left out, and of `request` the
/// indices into the plan: another plan that asks for the same finds the same
/// point. The numbers of elements in `request` replace those of the machine.
pub(super) fn placement_key(
    equations: PointKey,
    build: PointKey,
    pipeline: &NamedPipeline,
    machine: &NamedMachine,
    request: &PlacementRequest,
) -> PointKey {
    let machine = serde_json::to_string(&machine.machine).expect("a machine is plain data");
    equations
        // A key's file name is its hash as text.
        .with(&build.file_name())
        .with(&pipeline.pipeline.to_string())
        .with(&machine)
        .with(&format!("{}+{}", request.n_add, request.n_multi))
        // The names of the variants; they change with the build only.
        .with(&format!("{:?}", request.options))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Format, Machine};
    use robovec_passes::registry::REGISTRY;
    use robovec_schedule::{ElementChoice, PlaceOptions, Priority};

    /// Parts of a key.
    struct KeyParts {
        equations: PointKey,
        build: PointKey,
        pipeline: NamedPipeline,
        machine: NamedMachine,
        request: PlacementRequest,
    }

    impl KeyParts {
        fn key(&self) -> PointKey {
            placement_key(
                self.equations,
                self.build,
                &self.pipeline,
                &self.machine,
                &self.request,
            )
        }
    }

    fn example() -> KeyParts {
        KeyParts {
            equations: PointKey::new().with("function f equations {}"),
            build: PointKey::new().with("build"),
            pipeline: NamedPipeline {
                name: "usual".to_owned(),
                pipeline: REGISTRY.pipeline("atomise,cse,place").expect("a pipeline"),
                printed: None,
            },
            machine: NamedMachine {
                name: "thesis".to_owned(),
                machine: Machine::built_in("thesis").expect("it ships"),
                couple: None,
            },
            request: PlacementRequest {
                model: 0,
                pipeline: 0,
                machine: 0,
                n_add: 4,
                n_multi: 4,
                options: PlaceOptions::default(),
            },
        }
    }

    #[test]
    fn a_key_depends_on_everything_a_point_depends_on() {
        type Change = fn(&mut KeyParts);
        let changes: [(&str, Change); 12] = [
            ("nothing", |_| {}),
            ("equations", |parts| {
                parts.equations = parts.equations.with("another");
            }),
            ("build", |parts| parts.build = parts.build.with("another")),
            ("pipeline", |parts| {
                parts.pipeline.pipeline = REGISTRY.pipeline("atomise,place").expect("a pipeline");
            }),
            ("stages", |parts| {
                parts.machine.machine.elements[0].stages += 1
            }),
            ("words", |parts| {
                parts.machine.machine.memory.words = Some(77)
            }),
            ("number", |parts| {
                parts.machine.machine.number = Format::BINARY64
            }),
            ("adders", |parts| parts.request.n_add += 1),
            ("multipliers", |parts| parts.request.n_multi += 1),
            ("priority", |parts| {
                parts.request.options.priority = Priority::Alap
            }),
            ("another", |parts| {
                parts.request.options.priority = Priority::FanOut
            }),
            ("choice", |parts| {
                parts.request.options.choice = ElementChoice::First
            }),
        ];
        let mut keys = Vec::new();
        for (what, change) in changes {
            let mut parts = example();
            change(&mut parts);
            let key = parts.key();
            assert!(!keys.contains(&key), "{what}");
            keys.push(key);
        }
        // Two numbers that stand side by side are not taken for others.
        let mut parts = example();
        (parts.request.n_add, parts.request.n_multi) = (1, 12);
        let one = parts.key();
        (parts.request.n_add, parts.request.n_multi) = (11, 2);
        assert_ne!(one, parts.key());
    }
}
