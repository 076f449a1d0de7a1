//! Trials of each number of the table: a program that reads it and works with
//! it, on a small input.
//!
//! A number of a pass, a subcommand or a kind of file with a template is tried
//! automatically; one without fails the test with a message.

use super::run::Invocation;
use crate::docs::limits::LimitRow;
use std::fs;
use std::path::{Path, PathBuf};

/// A small model with sines and cosines.
fn pendulum() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/double-pendulum.mbs")
}

fn pendulum_text() -> String {
    fs::read_to_string(pendulum()).expect("it ships")
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

fn robovec(text: &str) -> Invocation {
    Invocation {
        program: "robovec",
        arguments: words(text),
    }
}

fn opt(text: &str) -> Invocation {
    Invocation {
        program: "robovec-opt",
        arguments: words(text),
    }
}

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).expect("a writable folder");
}

/// Files that a trial finds in its folder besides those that are made for it.
pub(crate) fn prepare(folder: &Path) {
    write(folder, "p.mbs", &pendulum_text());
    write(
        folder,
        "f.rvir",
        "// robovec 1\n\nfunction f equations {\n  in q[1..2]\n  out c[1..2]\n\n  \
         %a = q[1]*q[2] + 0.5*q[1]\n  c[1] = %a + q[2]\n  c[2] = %a*%a - q[1]\n}\n",
    );
    let symbolic = folder.join("project/symbolicR");
    fs::create_dir_all(&symbolic).expect("a writable folder");
    write(
        &symbolic,
        "mbs_dirdyna_p.c",
        "void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim)\n{\n  \
         c[1] = s->q[1]*s->q[2]+s->q[1];\n}\n",
    );
    write(&folder.join("project"), "result.txt", "1 2\n");
    write(&folder.join("project"), "p.mbs", &pendulum_text());
    write(
        folder,
        "r.rules",
        "rule some: a*b + a*c => a*(b + c)  class=real \"a common factor\";\n",
    );
}

/// The trials of a number: none when there is no template.
pub(crate) fn trials(title: &str, row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    match title {
        "Options of passes" => vec![pass(row, value)],
        "Flags of programs" => flag(row, value).into_iter().collect(),
        "Numbers in words of the command line" => vec![word(row, value)],
        "Machine files" => machine(row, value, folder),
        "Scenes" => scene(row, value, folder),
        "Laws of `robovec sim`" => laws(row, value, folder),
        "Plans of `robovec explore`" => plan(row, value, folder),
        "Models (.mbs)" => model(row, value, folder),
        "Robotran's files" => robotran(row, value, folder),
        "robovec's own text (.rvir)" => text(row, value, folder),
        _ => Vec::new(),
    }
}

const BEFORE: &str = "atomise,zero-removal,balance,cse,dce";

fn pass(row: &LimitRow, value: &str) -> Invocation {
    let (pass, option) = (row.place.as_str(), row.name.as_str());
    let with = match (pass, option) {
        ("trigonometry", "entries" | "degree" | "bits") => " on=host method=table",
        ("trigonometry", "iterations") => " on=host method=cordic",
        ("codegen", "lanes") => " target=batch",
        ("codegen", "part") => " target=c",
        ("accurate", "states") => " growth=50",
        ("mixed", "between") => " narrow=\"float(8,10)\"",
        _ => "",
    };
    let machine = match option {
        "n_div" | "n_sqrt" => "solver",
        "n_fma" => "fused",
        _ => "thesis",
    };
    let tried = match pass {
        "fixpoint" => format!("fixpoint{{{option}={value}}}(balance,cse,dce)"),
        "codegen" => format!("place,codegen{{{option}={value}{with}}}"),
        "place" => format!("place{{{option}={value}}},codegen"),
        _ => format!("{pass}{{{option}={value}{with}}}"),
    };
    Invocation {
        program: "robovec-opt",
        arguments: [
            "p.mbs",
            &format!("-passes={BEFORE},{tried}"),
            "--machine",
            machine,
            "-o",
            "out",
        ]
        .map(str::to_owned)
        .to_vec(),
    }
}

/// The command line of a subcommand, with the placeholder replaced by the value
/// of the flag.
fn flag(row: &LimitRow, value: &str) -> Option<Invocation> {
    let name = row.name.as_str();
    let base = match (row.place.as_str(), name) {
        ("robovec-opt", "--reduce-work") => "p.mbs -passes=atomise --auto-reduce -o out.rvir",
        ("robovec-opt", "--simulate") => "f.rvir -passes=atomise,place,codegen -o out",
        ("robovec-opt", _) => "f.rvir -passes=atomise --check-each=1 -o out.rvir",
        ("robovec", "--right-angles") => "model p.mbs",
        ("robovec", "--tool-seconds") => "eval f.rvir --random=1",
        ("robovec bench", _) => "serial-1 --peers=none --milliseconds=1 --rounds=1",
        ("robovec error", "--state" | "--window" | "--samples" | "--boxes") => "f.rvir --prove",
        ("robovec error", "--orders" | "--angles" | "--halvings") => {
            "p.mbs --series --states=4 --orders=1 --angles=0.1"
        }
        ("robovec error", _) => "f.rvir --states=8",
        ("robovec eval", _) => "f.rvir --random=1",
        ("robovec fit", _) => "s.scene.toml --states=8 --formulation=recursive",
        ("robovec project", _) => "project --run true --result result.txt",
        ("robovec gen", _) => "p.mbs --function accelred -o out.rvir",
        ("robovec explore", "--cpu-limit") => "--plan plan.toml -o out --cpu",
        ("robovec explore", "--elements" | "--angle" | "--states" | "--seed" | "--jobs") => {
            "f.rvir --elements=1 --states=8"
        }
        ("robovec explore", _) => {
            "serial-1 --adders=1 --multipliers=1 --couples=3-3 --memories=unified --buffers=16 \
             --instances=1"
        }
        ("robovec model", _) => "serial -o out.mbs",
        ("robovec optimise", _) => "f.rvir --effort=1 --states=8 --elements=1",
        ("robovec view", _) => "f.rvir --passes=atomise -o out.html",
        ("robovec sim", "--step") => "p.mbs --time=0.1 --method=rk4 --max-steps=1000",
        ("robovec sim", _) => "p.mbs --time=0.1 --samples=2 --max-steps=1000",
        ("robovec rtl simulate", _) => "img --inputs=1,1",
        ("robovec check", "--tolerance") => "f.rvir f.rvir --model p.mbs",
        ("robovec check", _) => "f.rvir f.rvir",
        ("robovec rtl", _) => "f.rvir --passes=atomise,place -o out --check=iverilog --runs=1",
        ("robovec rules check" | "robovec rules profile", _) => "r.rules",
        ("robovec rules find", "--window" | "--shapes" | "--values") => {
            "f.rvir --from f.rvir --window=3 --shapes=10 --values=1000"
        }
        ("robovec rules find", _) => "f.rvir --operations=2 --variables=2 --terms=1000",
        ("robovec rules why", _) => "a f.rvir --before=atomise",
        ("robovec rules why-not", _) => "a*x+b*x (a+b)*x",
        ("robovec rtl synthesise", _) => "--add=3 --multiply=3",
        _ => return None,
    };
    let subcommand = row.place.strip_prefix("robovec ").map(words);
    let mut arguments: Vec<String> = subcommand.into_iter().flatten().collect();
    let same = format!("{name}=");
    arguments.extend(
        words(base)
            .into_iter()
            .filter(|word| !word.starts_with(&same)),
    );
    // Two inputs take two numbers.
    match row.name.as_str() {
        "--inputs" => arguments.push(format!("{name}={value},{value}")),
        _ => arguments.push(format!("{name}={value}")),
    }
    Some(Invocation {
        program: match row.place.as_str() {
            "robovec-opt" => "robovec-opt",
            _ => "robovec",
        },
        arguments,
    })
}

/// Files that flags and fields need in the folder besides [`prepare`].
pub(crate) fn prepare_more(folder: &Path) {
    let place = opt("f.rvir -passes=atomise,place,codegen -o img");
    let ending = place.run(folder, 60);
    assert_eq!(ending.code, Some(0), "{}", ending.told);
    write(folder, "plan.toml", &plan_text("[1]", "[1]"));
    write(folder, "s.scene.toml", &scene_text("", ""));
}

fn word(row: &LimitRow, value: &str) -> Invocation {
    match row.name.as_str() {
        "serial-N" => robovec(&format!(
            "explore serial-{value} --adders=1 --multipliers=1 --couples=3-3 --memories=unified \
             --buffers=16 --instances=1 --passes=atomise"
        )),
        "--number BITS" => robovec(&format!("eval f.rvir --random=4 --number={value}")),
        _ => opt(&format!(
            "f.rvir -passes=atomise,cse --bisect-limit={value}:{value} -o out.rvir"
        )),
    }
}

fn machine(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let of = |name: &str, usual: &str| {
        if row.name == name {
            value.to_owned()
        } else {
            usual.to_owned()
        }
    };
    let optional = |name: &str| {
        if row.name == name {
            format!("{} = {value}\n", name.rsplit('.').next().unwrap_or(name))
        } else {
            String::new()
        }
    };
    let network = match row.name.strip_prefix("interconnect.") {
        Some(field) => format!("interconnect = {{kind = \"mesh\", {field} = {value}}}\n"),
        None => String::new(),
    };
    // A network has no more columns than elements.
    let elements = match (row.name.as_str(), value.parse()) {
        ("interconnect.columns", Ok(1..=4096)) => value.to_owned(),
        _ => of("element.count", "2"),
    };
    let element = |kind: &str, operations: &str| {
        format!(
            "[[element]]\nkind = \"{kind}\"\noperations = [{operations}]\ncount = {}\n\
             stages = {}\ntransfer = {}\n\n",
            elements,
            of("element.stages", "3"),
            of("element.transfer", "2"),
        )
    };
    let text = format!(
        "name = \"tried\"\nclock_mhz = {}\n{network}\n[number]\nexponent = {}\nmantissa = {}\n\
         subnormals = true\n\n{}{}[memory]\nstyle = \"unified\"\n{}writes = {}\n\n\
         [buffer]\n{}reads = {}\n\n[instructions]\n{}\n[resources]\n{}{}{}",
        of("clock_mhz", "100.0"),
        of("number.exponent", "8"),
        of("number.mantissa", "23"),
        element("add", "\"add\", \"sub\""),
        element("multi", "\"mul\""),
        optional("memory.words"),
        of("memory.writes", "2"),
        optional("buffer.words"),
        of("buffer.reads", "1"),
        optional("instructions.words"),
        optional("resources.logic"),
        optional("resources.memory_blocks"),
        optional("resources.multipliers"),
    );
    write(folder, "m.toml", &text);
    vec![
        opt(
            "f.rvir -passes=atomise,place,codegen --machine m.toml --simulate=1 --report r.json -o out",
        ),
        opt("f.rvir -passes=atomise,place,codegen{target=rtl} --machine m.toml -o out"),
        opt("p.mbs -passes=atomise,lookahead,balance,cse,dce,place --machine m.toml -o out.rvir"),
    ]
}

fn scene_text(head: &str, tail: &str) -> String {
    format!(
        "name = \"tried\"\nequations = \"f.rvir\"\n{head}\n[[output]]\nelements = [\"c[1]\"]\n{tail}"
    )
}

fn motion(words: &str) -> String {
    format!("model = \"p.mbs\"\nfunction = \"accelred\"\n\n[motion]\nwatch = [\"1\"]\n{words}\n")
}

fn scene(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let text = match row.name.as_str() {
        "deadline" => scene_text(&format!("deadline = {value}"), ""),
        "output.error" => scene_text("", &format!("error = {value}\n")),
        "output.scale" => scene_text("", &format!("error = 1e-3\nscale = {value}\n")),
        "motion.time" => motion(&format!("time = {value}")),
        "motion.energy" => motion(&format!("time = 0.1\nenergy = {value}")),
        "motion.error" => motion(&format!("time = 0.1\nerror = {value}")),
        "motion.start" => motion(&format!("time = 0.1\nstart = {{ R1_Upper = {value} }}")),
        "bind" => scene_text("", &format!("\n[bind]\n\"q[1]\" = {value}\n")),
        "range" => scene_text("", &format!("\n[range]\nq = [{value}, {value}]\n")),
        _ => format!(
            "name = \"tried\"\nmodel = \"p.mbs\"\nfunction = \"accelred\"\n\n[locked]\nR1_Upper = {value}\n"
        ),
    };
    write(folder, "t.scene.toml", &text);
    vec![
        robovec("fit t.scene.toml --explain"),
        opt("t.scene.toml -passes=atomise,specialise,balance,cse,dce,accurate,mixed -o out.rvir"),
        robovec("fit t.scene.toml --states=8"),
    ]
}

fn laws(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let name = row.name.as_str();
    let text = match name {
        "stiffness" | "damping" | "neutral" | "force" => {
            format!("[[joint]]\nname = \"R1_Lower\"\n{name} = {value}\n")
        }
        "friction" | "slip" => format!(
            "[[joint]]\nname = \"R1_Lower\"\nfriction = 1.0\n{name} = {value}\n"
        )
        .replacen("friction = 1.0\nfriction", "friction", 1),
        "value" => format!("[[event]]\nname = \"R1_Lower\"\n{name} = {value}\n"),
        "normal" => format!("[[contact]]\nname = \"*\"\n{name} = [0, {value}, 0]\n"),
        "radius" | "axis" | "longitudinal" | "lateral" | "B" | "C" | "D" | "E" => tyre(name, value),
        "torque" => format!("[[force]]\nname = \"*\"\n{name} = [{value}, 0, 0]\n"),
        _ => format!(
            "[[driven]]\nname = \"R1_Upper\"\namplitude = 0.1\nfrequency = 1.0\n{name} = {value}\n"
        )
        .replacen(&format!("{name} = 0.1\n"), "", 1)
        .replacen("frequency = 1.0\nfrequency", "frequency", 1),
    };
    write(folder, "laws.toml", &text);
    let driven = pendulum_text().replacen("<nature>independent", "<nature>driven", 1);
    write(folder, "d.mbs", &driven);
    let model = match name {
        "offset" | "amplitude" | "frequency" | "phase" => "d.mbs",
        _ => "p.mbs",
    };
    vec![robovec(&format!(
        "sim {model} --laws laws.toml --time=0.1 --max-steps=100000"
    ))]
}

/// A tyre with one number.
fn tyre(name: &str, value: &str) -> String {
    let entry = |key: &str, usual: &str| {
        let number = if key == name { value } else { usual };
        format!("{key} = {number}")
    };
    let common = format!(
        "[[tyre]]\nname = \"*\"\nstiffness = 1.0\n{}\n",
        entry("radius", "0.3")
    );
    let curve = ["B", "C", "D", "E"].map(|key| entry(key, "1.0")).join(", ");
    let law = match name {
        "axis" => format!("axis = [0, 1, {value}]\n"),
        _ => String::new(),
    } + &match name {
        "B" | "C" | "D" | "E" => {
            format!("law = \"bakker\"\nlongitudinal = {{ {curve} }}\nlateral = {{ {curve} }}\n")
        }
        _ => format!(
            "law = \"linear\"\nfriction = 1.0\n{}\n{}\n",
            entry("longitudinal", "1e3"),
            entry("lateral", "1e3")
        ),
    };
    common + &law
}

fn plan_text(elements: &str, grid: &str) -> String {
    format!(
        "name = \"tried\"\n\n[[model]]\nname = \"serial-1\"\n\n[[pipeline]]\nname = \"short\"\n\
         passes = \"$shorten\"\n\n[[sweep]]\nelements = {elements}\ngrid = {grid}\n"
    )
}

fn plan(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let text = match row.name.as_str() {
        "sweep.elements" => plan_text(&format!("[{value}]"), "[1]"),
        _ => plan_text("[1]", &format!("[{value}]")),
    };
    write(folder, "t.toml", &text);
    vec![robovec("explore --plan t.toml -o out")]
}

fn model(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let text = pendulum_text();
    if row.name == "joint" {
        let count = value.parse::<usize>().unwrap_or(0);
        let (head, rest) = text.split_once("<body>").expect("it has bodies");
        let (body, rest) = rest.split_once("</body>").expect("it has bodies");
        let (_, tail) = rest.rsplit_once("</body>").expect("it has bodies");
        let mut long = head.to_owned();
        for number in 0..count.min(10_000) {
            let mut body = body.replace("Upper", &format!("B{number}"));
            if number > 0 {
                let parent = format!("<bodyname>B{}</bodyname><pointname>Elbow", number - 1);
                body = body.replace("<bodyname>base</bodyname><pointname>origin", &parent);
            }
            long += &format!("<body>{body}</body>\n");
        }
        write(folder, "t.mbs", &(long + tail));
        return vec![
            robovec("model t.mbs"),
            robovec("gen t.mbs -o out.rvir"),
            robovec("gen t.mbs --function accelred --formulation articulated -o out.rvir"),
        ];
    }
    let text = text
        .replacen("<mass>2.0", &format!("<mass>{value}"), 1)
        .replacen("<z>-1.0", &format!("<z>{value}"), 1)
        .replacen("<q>0.5", &format!("<q>{value}"), 1);
    write(folder, "t.mbs", &text);
    vec![
        robovec("model t.mbs"),
        robovec("gen t.mbs --numbers -o out.rvir"),
        robovec("eval t.mbs --random=2"),
        robovec("sim t.mbs --time=0.01 --max-steps=1000"),
        opt(
            "t.mbs -passes=atomise,fold,balance,cse,dce,place,codegen --simulate=1 --check-each=2 -o out",
        ),
    ]
}

fn robotran(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let (comment, index) = match row.name.as_str() {
        "index" => ("Project name : tried".to_owned(), value),
        "Number of joints (comment)" => (format!("Number of joints : {value}"), "1"),
        _ => (
            format!("Array extents : q({value}) M({value},{value})"),
            "1",
        ),
    };
    let text = format!(
        "%\tROBOTRAN - Version 6.6\n%\t==> {comment}\n\nfunction [M,c] = dirdyna(s,tsim,usrfun)\n\
         \n  q = s.q;\n  M = zeros(1,1);\n  c = zeros(1,1);\n\n  C1 = cos(q({index}));\n\n  \
         c(1) = C1*q({index});\n  M(1,1) = C1;\n\n% ====== END Task 0 ======\n"
    );
    write(folder, "t.m", &text);
    vec![
        opt("t.m -passes=atomise,cse,place,codegen --check-each=1 -o out"),
        robovec("eval t.m --random=2"),
        robovec("gen t.m --language c -o out"),
    ]
}

fn text(row: &LimitRow, value: &str, folder: &Path) -> Vec<Invocation> {
    let of = |name: &str, usual: &str| {
        if row.name == name {
            value.to_owned()
        } else {
            usual.to_owned()
        }
    };
    let name = row.name.as_str();
    if name.starts_with("elements of all") {
        let text = format!(
            "// robovec 1\n\nfunction f equations {{\n  in q[1..{}]\n  out c[1..{}]\n\n  \
             c[1] = q[1]*q[1]\n}}\n",
            of("elements of all inputs", "1"),
            of("elements of all outputs", "1"),
        );
        write(folder, "t.rvir", &text);
        return vec![
            opt("t.rvir -passes=atomise,cse,place,codegen --check-each=1 -o out"),
            robovec("eval t.rvir --random=1"),
            opt("t.rvir -passes=atomise,interleave{instances=64} -o out.rvir"),
        ];
    }
    let text = format!(
        "// robovec 1\n\nfunction f placed {{\n  in q[1..2]\n  out c[1..1]\n\n  \
         schedule \"thesis\" add*{} multi*4 cycles {} bound {}\n\n  \
         preload add0[0] = q[1]\n  preload add0[{}] = q[2]\n\n  \
         %a = q[1] + q[2] on add0 at {} read 0 {}\n  c[1] = %a\n}}\n",
        of("elements of a kind in a schedule", "4"),
        of("cycle", "12"),
        of("cycle", "12"),
        of("address", "1"),
        of("cycle", "0"),
        of("address", "1"),
    );
    write(folder, "t.rvir", &text);
    vec![
        opt("t.rvir -passes=asap-alap --report r.txt -o out.rvir"),
        opt("t.rvir -passes=codegen --simulate=1 -o out"),
        opt("t.rvir -passes=codegen{target=rtl} -o out"),
        opt("t.rvir -passes=place -o out.rvir"),
    ]
}
