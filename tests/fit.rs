//! Choices of `robovec fit` for random scenes, searched by hill climbing that
//! shares no code with the product's own search: none exceeds its tolerance.

use crate::reference::random::{self, ModelDraw, Recipe};
use crate::support::programs::{robovec, said, stderr};
use robovec::model::mbs::write_mbs;
use robovec::scene::SceneFile;
use robovec_framework::scene::{Allowed, ArraySizes};
use robovec_ir::parse::parse_module;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::print::print_operand;
use robovec_ir::states::States;
use robovec_ir::{Format, Input, Module, View};
use robovec_num::arithmetic::{Arithmetic, Binary64};
use robovec_num::batch::Batch;
use robovec_num::double_double::{DoubleDoubleLanes, DoubleLanes};
use robovec_num::random::Random;
use robovec_num::soft_float::{FormatArithmetic, FormatLanes};
use std::fs;
use std::path::Path;

/// Number of climbs, each from a drawn state.
const CLIMBS: u64 = 24;

/// States without a larger error after which a climb begins anew.
const PATIENCE: u32 = 2000;

/// Number of states evaluated at once, the children of a step.
const LANES: usize = 8;

fn view(module: &Module) -> View<'_> {
    View {
        tables: &module.tables,
        function: &module.functions[0],
    }
}

fn names(view: View<'_>) -> Vec<String> {
    let inputs = 0..view.function.input_len() as u32;
    let name = |index| print_operand(view, Input(index).into());
    inputs.map(name).collect()
}

/// Numbers of bodies of larger scenes, each with one to three joints.
const BODIES: [usize; 10] = [2, 4, 6, 8, 10, 12, 14, 17, 20, 25];

/// A random scene in a folder: a tree of bodies, with cuts for every third seed
/// of two digits.
fn write_scene(folder: &Path, seed: u64, bodies: usize) {
    let mut random = Random::new(seed);
    let is_loop = seed >= 10 && seed.is_multiple_of(3);
    let recipe = Recipe {
        bodies,
        zeros: 0.5,
        massless: false,
        driven: false,
        placed: false,
        cuts: usize::from(is_loop),
        devices: 0,
    };
    let model = random::model(&mut random, &recipe);
    fs::write(folder.join("random.mbs"), write_mbs(&model)).expect("it can be written");
    // Accelerations of loops are defined at closed states alone.
    let first = if is_loop {
        ("cons_hJ", "Jac")
    } else {
        ("accelred", "qdd")
    };
    let (function, output) = [first, ("invdyna", "Qq"), ("dirdyna", "c")][random.below(3)];
    let measure = ["norm", "absolute", "relative"][random.below(3)];
    let error = 10f64.powf(random.between(-5.0, -2.0));
    let trigonometry = ["host", "elements"][random.below(2)];
    let [q, qd, qdd] = [1.5, 5.0, 10.0].map(|most| most * random.between(0.1, 1.0));
    let text = format!(
        "name = \"random {seed}\"\nmodel = \"random.mbs\"\nfunction = \"{function}\"\n\
         machine = \"solver\"\ndeadline = 1000.0\nparameters = \"from-model\"\n\
         trigonometry = \"{trigonometry}\"\n\n\
         [[output]]\nelements = [\"{output}\"]\nerror = {error:e}\nmeasure = \"{measure}\"\n\n\
         [bind]\nfrc = 0.0\ntrq = 0.0\n\n\
         [range]\nq = [-{q}, {q}]\nqd = [-{qd}, {qd}]\nqdd = [-{qdd}, {qdd}]\n\
         Qq = [-{qdd}, {qdd}]\n"
    );
    fs::write(folder.join("random.scene.toml"), text).expect("it can be written");
}

/// A choice with its alternatives.
struct Choice {
    scene: SceneFile,
    general: Module,
    program: Module,
    format: Format,
    sizes: ArraySizes,
    /// For every input of the program its place among those of the function.
    inputs: Vec<usize>,
    /// For every output of the program its place among the assignments.
    outputs: Vec<usize>,
}

impl Choice {
    /// The choice of `robovec fit`; `None` where no program meets the scene.
    fn of(folder: &Path) -> Option<Choice> {
        let scene = folder.join("random.scene.toml");
        let out = folder.join("out");
        let [scene_name, out_name] = [&scene, &out].map(|path| path.to_string_lossy());
        let outcome = robovec(&["fit", &scene_name, "-o", &out_name]);
        if stderr(&outcome).contains("no program meets the scene") {
            return None;
        }
        said(&outcome);
        let text = |name: &str| fs::read_to_string(out.join(name)).expect("it was written");
        let json: serde_json::Value = serde_json::from_str(&text("fit.json")).expect("JSON");
        let chosen = json["chosen"].as_u64()? as usize;
        let format = json["candidates"][chosen]["format"].as_str();
        let format = format.expect("a name").parse().expect("a format");
        let program = parse_module("program", &text("program.rvir")).expect("it is well formed");
        let scene = SceneFile::load(&scene).unwrap_or_else(|error| panic!("{error:?}"));
        let general = scene.module().expect("it was generated before");
        let all = names(view(&general));
        let place = |name: String| all.iter().position(|one| *one == name);
        let inputs = names(view(&program)).into_iter().map(place);
        let set = |module: &Module| {
            let of = |view: View<'_>| {
                let set = view.function.assignments.iter();
                set.map(|one| robovec_ir::print::print_output(view, one.output))
                    .collect::<Vec<_>>()
            };
            of(view(module))
        };
        let all_outputs = set(&general);
        let outputs = set(&program).into_iter().map(|name| {
            let place = all_outputs.iter().position(|one| *one == name);
            place.expect("the function has it")
        });
        Some(Choice {
            sizes: ArraySizes::of(view(&general), Some(&scene.scene)),
            inputs: inputs.map(|place| place.expect("it has it")).collect(),
            outputs: outputs.collect(),
            scene,
            general,
            program,
            format,
        })
    }

    /// The largest share that climbs find, in this number of states: candidates
    /// are judged in binary64, the best of each climb in double-double.
    fn climbed(&self, states: u64, seed: u64) -> f64 {
        let search = Search::new(self, seed);
        let threads = std::thread::scope(|scope| {
            let halves = [0, 1].map(|half| {
                let search = &search;
                scope.spawn(move || {
                    let own = (0..CLIMBS).filter(|number| number % 2 == half);
                    own.map(|number| search.climb(number, states / CLIMBS))
                        .fold(0.0, f64::max)
                })
            });
            halves.map(|half| half.join().expect("a climb ends"))
        });
        threads.into_iter().fold(0.0, f64::max)
    }
}

/// A search for the states at which a choice is worst.
struct Search<'a> {
    choice: &'a Choice,
    /// The outputs of the program as the general function computes them.
    reference: EvaluationPlan,
    program: EvaluationPlan,
    allowed: Allowed,
    source: States,
    /// Inputs that vary, with their ranges.
    ranges: Vec<(usize, [f64; 2])>,
    seed: u64,
}

impl<'a> Search<'a> {
    fn new(choice: &'a Choice, seed: u64) -> Search<'a> {
        let general = view(&choice.general);
        let source = choice.scene.scene.states(seed);
        let range = |place: usize| {
            let (array, indices, _) = general.function.input_element(Input(place as u32));
            let name = general.tables.symbols.text(array.name);
            let range = source.ranges().get(name, indices)?;
            (range[0] < range[1]).then_some((place, range))
        };
        let scene = Some(&choice.scene.scene);
        let ranges = (0..general.function.input_len()).filter_map(range);
        Search {
            reference: EvaluationPlan::of(general.function, |output| {
                choice.outputs.contains(&output)
            }),
            program: EvaluationPlan::new(view(&choice.program).function),
            allowed: Allowed::new(view(&choice.program), scene, f64::INFINITY, &choice.sizes),
            ranges: ranges.collect(),
            choice,
            source,
            seed,
        }
    }

    /// The outputs in an arithmetic, in the order of the program's.
    fn reference<A: Arithmetic>(&self, arithmetic: &A, inputs: &[A::Number]) -> Vec<A::Number> {
        let outputs = self.reference.run(arithmetic, inputs, &mut Vec::new());
        let mut sorted = self.choice.outputs.clone();
        sorted.sort_unstable();
        let place = |output| sorted.binary_search(output).expect("it is among them");
        let of = |output| outputs[place(output)];
        self.choice.outputs.iter().map(of).collect()
    }

    /// The largest ratio of an error to the allowed one in each of the states,
    /// against double-double or binary64.
    fn shares(&self, states: &[Vec<f64>; LANES], is_exact: bool) -> [f64; LANES] {
        let lane = |place: usize| states.each_ref().map(|state| state[place]);
        let inputs: Vec<[f64; LANES]> = (0..states[0].len()).map(lane).collect();
        let exact: Vec<[f64; LANES]> = if is_exact {
            let inputs: Vec<_> = inputs.iter().copied().map(DoubleLanes::new).collect();
            let exact = self.reference(&DoubleDoubleLanes::<LANES>, &inputs);
            let high =
                |value: DoubleLanes<LANES>| std::array::from_fn(|lane| value.lane(lane).high);
            exact.into_iter().map(high).collect()
        } else {
            self.reference(&Batch([Binary64; LANES]), &inputs)
        };
        let single = FormatArithmetic::new(self.choice.format);
        let round = |&place: &usize| inputs[place].map(|number| single.literal(number));
        let inputs: Vec<[f64; LANES]> = self.choice.inputs.iter().map(round).collect();
        let computed = (self.program).run(&FormatLanes(single), &inputs, &mut Vec::new());
        std::array::from_fn(|lane| {
            let exact: Vec<f64> = exact.iter().map(|value| value[lane]).collect();
            let pairs = computed.iter().zip(&exact).zip(self.allowed.of(&exact));
            let shares =
                pairs.map(|((value, exact), allowed)| (value[lane] - exact).abs() / allowed);
            shares.fold(0.0, f64::max)
        })
    }

    /// The largest share that one climb meets.
    fn climb(&self, number: u64, states: u64) -> f64 {
        let general = view(&self.choice.general);
        let drawn = |step: u64| self.source.draw(general, (number + step * CLIMBS) as u32);
        let mut random = Random::new(self.seed ^ (number << 20));
        let mut best = (0.0, drawn(0));
        let (mut most, mut since) = (0.0f64, 0);
        for step in 0..states / LANES as u64 {
            if since > PATIENCE {
                best = (0.0, drawn(step));
                since = 0;
            }
            let children = [(); LANES].map(|()| self.child(&best.1, &mut random));
            let shares = self.shares(&children, false);
            since += LANES as u32;
            let worst = (0..LANES).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
            let worst = worst.expect("there are lanes");
            if shares[worst] >= best.0 {
                since = if shares[worst] > best.0 { 0 } else { since };
                best = (shares[worst], children[worst].clone());
                if best.0 > most {
                    let exact = self.shares(&[(); LANES].map(|()| best.1.clone()), true);
                    most = most.max(exact[0]);
                }
            }
        }
        most
    }

    /// A state with some values of another one changed.
    fn child(&self, state: &[f64], random: &mut Random) -> Vec<f64> {
        let mut state = state.to_vec();
        for _ in 0..=random.below(3) {
            let (place, [low, high]) = self.ranges[random.below(self.ranges.len())];
            let scale = (high - low) * 0.5f64.powi(random.below(30) as i32);
            state[place] = match random.below(6) {
                0 => [low, high][random.below(2)],
                1 => random.between(low, high),
                _ => (state[place] + scale * random.signed()).clamp(low, high),
            };
        }
        state
    }
}

/// The share of the tolerance that climbs find for a random scene.
fn found(seed: u64, bodies: usize, states: u64) -> Option<f64> {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    write_scene(folder.path(), seed, bodies);
    let choice = Choice::of(folder.path())?;
    Some(choice.climbed(states, seed))
}

#[test]
fn a_choice_holds_under_a_search_that_is_not_its_own() {
    let found = found(1, 2, 20_000).expect("a program meets the scene");
    assert!((0.05..=1.0).contains(&found), "{found}");
}

/// Thirty scenes, a million states each (`ROBOVEC_FIRST=1 ROBOVEC_SCENES=30 ROBOVEC_STATES=…`).
#[test]
#[ignore = "two hours"]
fn thirty_choices_hold_under_a_million_states_each() {
    let number = |name, usual| match std::env::var(name) {
        Ok(text) => text.parse().expect("a number"),
        Err(_) => usual,
    };
    let (scenes, states) = (
        number("ROBOVEC_SCENES", 30),
        number("ROBOVEC_STATES", 1_000_000),
    );
    let mut over = Vec::new();
    for seed in number("ROBOVEC_FIRST", 1)..=scenes {
        let bodies = match seed {
            0..10 => 3 + seed as usize,
            _ => BODIES[seed as usize % BODIES.len()],
        };
        let share = found(seed, bodies, states);
        eprintln!("scene {seed}, {bodies} bodies: {share:?} of the tolerance");
        if share.is_some_and(|share| share > 1.0) {
            over.push((seed, share));
        }
    }
    assert!(over.is_empty(), "{over:?}");
}
