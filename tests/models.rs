//! Models: the examples equal the program's output, and every mistake in a file
//! is reported with its place and a remedy.

use crate::support::files::{compare_with_record, each, list, name};
use crate::support::programs::robovec;
use robovec::model::family::{self, ModelFamily, built_in};
use robovec::model::mbs::{read_mbs, write_mbs};
use robovec::robotran::conventions::JOINT_LIMIT;
use std::fs;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The `.mbs` files of a folder, sorted.
/// `semi-serial-23` is 23 joints of a family; a family of one size is its own
/// name.
fn family_of(stem: &str) -> (ModelFamily, Option<usize>) {
    if let Some(family) = ModelFamily::from_name(stem) {
        return (family, None);
    }
    let (family, joints) = stem.rsplit_once('-').expect("a family and a number");
    (
        ModelFamily::from_name(family).expect("a family"),
        Some(joints.parse().expect("a number")),
    )
}

/// With INSTA_UPDATE=always the examples are written instead.
#[test]
fn the_examples_are_what_the_command_writes() {
    let mut stems: Vec<String> = ModelFamily::ALL
        .iter()
        .filter(|family| family.joints().is_some())
        .map(|family| family.name().to_owned())
        .collect();
    for family in ["serial", "semi-serial", "parallel"] {
        stems.extend([23, 50, 70, 100, 130].map(|joints| format!("{family}-{joints}")));
    }
    stems.sort();
    let folder = root().join("examples/models");
    for stem in &stems {
        let (family, joints) = family_of(stem);
        let number = joints.map(|joints| joints.to_string());
        let mut arguments = vec!["model", family.name()];
        if let Some(number) = &number {
            arguments.extend(["--joints", number]);
        }
        let output = robovec(&arguments);
        assert!(output.status.success(), "{stem}");
        let path = folder.join(format!("{stem}.mbs"));
        if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
            fs::write(&path, &output.stdout).expect("the examples can be written");
        }
        let example = fs::read(&path).unwrap_or_default();
        assert!(
            example == output.stdout,
            "{stem}.mbs is not what is written"
        );
        let read = read_mbs(stem, &example).expect("our own model");
        assert!(read.warnings.is_empty(), "{}", read.warnings.render_plain());
        let model = family.build(joints.unwrap_or_default(), 1);
        assert!(read.model == model, "{stem}");
    }
    let there: Vec<String> = list("examples/models", &["mbs"])
        .iter()
        .map(|path| name(path))
        .collect();
    let expected: Vec<String> = stems.iter().map(|stem| format!("{stem}.mbs")).collect();
    assert_eq!(there, expected);
}

#[test]
fn mistakes_are_told_with_place_and_advice() {
    each("tests/models/errors", &["mbs"], |path| {
        let bytes = fs::read(path).expect("it can be read");
        let name = name(path);
        let shown = match read_mbs(&name, &bytes) {
            Ok(read) if read.warnings.is_empty() => panic!("{name}: nothing is wrong"),
            Ok(read) => {
                let again = read_mbs("again", write_mbs(&read.model).as_bytes());
                assert!(again.is_ok_and(|again| again.model == read.model), "{name}");
                read.warnings.render_plain()
            }
            Err(error) => {
                assert!(error.report.has_errors(), "{name}");
                error.report.render_plain()
            }
        };
        let folder = path.parent().expect("a folder");
        compare_with_record(&folder.join("snapshots"), &name, shown.trim_end());
    });
}

#[test]
fn a_refused_model_exits_with_1_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let result = folder.path().join("result");
    let result = result.to_str().expect("a plain name");
    for path in list("tests/models/errors", &["mbs"]) {
        let bytes = fs::read(&path).expect("it can be read");
        if read_mbs("m", &bytes).is_ok() {
            continue;
        }
        let path = path.to_str().expect("a plain name");
        for arguments in [["model", path, "-o", result], ["gen", path, "-o", result]] {
            let output = robovec(&arguments);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{path}: {message}");
            assert!(!message.contains("panicked"), "{message}");
            assert!(output.stdout.is_empty() && !Path::new(result).exists());
        }
    }
}

/// A body without a mass has mass zero, as in Robotran.
#[test]
fn a_body_without_a_mass_weighs_nothing() {
    for (name, element) in [
        ("missing-mass", "inertia"),
        ("missing-mass-with-centre", "com"),
    ] {
        let path = root().join(format!("tests/models/{name}.mbs"));
        let output = robovec(&["model", path.to_str().expect("a plain name")]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{message}");
        assert!(
            message.contains("warning: body 'Arm' has no mass"),
            "{message}"
        );
        assert!(
            message.contains(&format!("but `{element}` is given")),
            "{message}"
        );
        assert!(message.contains("taken as 0"), "{message}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("no mass"));
    }
}

/// Links that are in no equation get a remark where equations are made, and
/// only there.
#[test]
fn a_link3d_is_told_by_gen_and_refused_by_sim() {
    let path = root().join("tests/models/link3d.mbs");
    let path = path.to_str().expect("a plain name");
    let told = |arguments: &[&str]| {
        let output = robovec(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), message, output.stdout)
    };
    let sentence = "link3D 'Bushing' is left out of the equations";
    for (function, expected) in [
        ("all", true),
        ("dirdyna", true),
        ("invdyna", true),
        ("accelred", true),
        ("gensensor", false),
    ] {
        let (code, message, written) = told(&["gen", path, "--function", function]);
        assert_eq!(code, Some(0), "{function}: {message}");
        assert!(!written.is_empty(), "{function}");
        assert_eq!(
            message.contains(sentence),
            expected,
            "{function}: {message}"
        );
        assert_eq!(
            message.contains("warning"),
            expected,
            "{function}: {message}"
        );
        assert_eq!(message.contains("link3d.mbs:30:13"), expected, "{message}");
    }
    let (code, message, written) = told(&["sim", path]);
    assert_eq!(code, Some(1), "{message}");
    assert!(
        message.contains("error") && message.contains(sentence),
        "{message}"
    );
    assert!(message.contains("remove it from the model"), "{message}");
    assert!(written.is_empty());
    let (code, message, _) = told(&["model", path]);
    assert_eq!((code, message.as_str()), (Some(0), ""));
}

/// A model with these lines in its tree of bodies.
fn model_of(bodies: &str) -> String {
    format!("<mbsDescR7><mbsname>m</mbsname><base/><bodytree>{bodies}</bodytree></mbsDescR7>")
}

fn refusal(text: &[u8]) -> String {
    match read_mbs("hostile.mbs", text) {
        Ok(_) => panic!("it is accepted"),
        Err(error) => {
            let shown = error.report.render_plain();
            assert!(shown.len() < 50_000, "a message of {} bytes", shown.len());
            shown
        }
    }
}

#[test]
fn huge_and_hostile_files_are_refused_in_time() {
    let joint =
        "<joint><jointname>J</jointname><type>R1</type><nature>independent</nature></joint>";
    let many = model_of(&format!(
        "<body><bodyname>B</bodyname>{}</body>",
        joint.repeat(10_000)
    ));
    let shown = refusal(many.as_bytes());
    assert!(
        shown.contains("joints of the model: 10000 is not allowed")
            && shown.contains(&JOINT_LIMIT.to_string()),
        "{shown}"
    );
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    let shown = refusal(deep.as_bytes());
    assert!(shown.contains("not a model"), "{shown}");
    // What is passed over may be nested as deep as it likes.
    let inside = model_of(&deep);
    let shown = refusal(inside.as_bytes());
    assert!(shown.contains("the model has no body"), "{shown}");
    let open = "<a>".repeat(100_000);
    assert!(refusal(open.as_bytes()).contains("cut short"));
    let attributes: String = (0..100_000).map(|n| format!(" a{n}=\"\"")).collect();
    let shown = refusal(format!("<mbsDescR7{attributes}/>").as_bytes());
    assert!(shown.contains("too many attributes"), "{shown}");
    let chain: String = (0..JOINT_LIMIT)
        .map(|n| {
            format!(
                "<body><bodyname>B{n}</bodyname><parent><bodyname>B{}</bodyname>\
                 <pointname>origin</pointname></parent>{}</body>",
                (n + 1) % JOINT_LIMIT,
                joint.replace('J', &format!("J{n}"))
            )
        })
        .collect();
    let shown = refusal(model_of(&chain).as_bytes());
    assert!(
        shown.contains("these bodies are parents of one another"),
        "{shown}"
    );
    // Work that grows with the square of the file would take minutes here.
    let joint_less = model_of(&"<body><bodyname>B</bodyname></body>".repeat(100_000));
    assert!(refusal(joint_less.as_bytes()).contains("100000 is not allowed"));
    let body = format!(
        "<body><bodyname>B</bodyname><parent><bodyname>base</bodyname><pointname>origin\
         </pointname></parent>{joint}<mass>1</mass>{}</body>",
        (0..50_000)
            .map(|n| format!("<point><pointname>P{n}</pointname><coordinates/></point>"))
            .collect::<String>()
    );
    let lost = "<link><name>L</name><endpoint1><bodyname>B</bodyname><pointname>Q123</pointname>\
                </endpoint1><endpoint2><bodyname>C</bodyname><pointname>P</pointname></endpoint2>\
                </link>";
    let links = model_of(&body).replace(
        "</bodytree>",
        &format!("</bodytree><links>{}</links>", lost.repeat(50_000)),
    );
    assert!(refusal(links.as_bytes()).contains("there are more"));
    let repeated = model_of(&body.replace("</body>", &"<mass>1</mass>".repeat(200_000)));
    let repeated = repeated.replace("</bodytree>", "</body></bodytree>");
    assert!(refusal(repeated.as_bytes()).contains("given twice"));
    assert!(refusal(&[0, 159, 146, 150]).contains("not text"));
    assert!(refusal(b"").contains("no element"));
}

#[test]
fn equations_that_would_fill_the_memory_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let model = folder.path().join("chain.mbs");
    fs::write(&model, write_mbs(&family::serial(JOINT_LIMIT, 1))).expect("room for it");
    let model = model.to_str().expect("a plain name");
    for function in ["dirdyna", "gensensor"] {
        let output = robovec(&["gen", model, "--function", function]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("2001000 ancestors"), "{message}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn encodings_are_told_apart() {
    let text = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n".to_owned()
        + &write_mbs(&built_in("double-pendulum").expect("a family")).replace("Upper", "Père");
    let text = text.replacen("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n", "", 1);
    let latin: Vec<u8> = text
        .chars()
        .map(|c| u8::try_from(c).expect("Latin-1"))
        .collect();
    let mut utf_8 = b"\xef\xbb\xbf".to_vec();
    utf_8.extend(text.bytes());
    let utf_16: Vec<u8> = std::iter::once(0xfeff)
        .chain(text.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    for bytes in [latin, utf_8, utf_16, text.into_bytes()] {
        let read = read_mbs("m", &bytes).expect("every encoding");
        assert_eq!(read.model.bodies[0].name, "Père");
    }
}

#[test]
fn the_command_refuses_what_it_cannot_do() {
    for (arguments, words) in [
        (&["model", "bogei"][..], "did you mean 'bogie'"),
        (
            &["model", "bogie", "--joints", "24"],
            "always has 23 joints",
        ),
        (&["model", "bogie", "--seed", "2"], "no effect"),
        (&["model", "serial", "--joints", "0"], "1 to 2000"),
        (&["model", "serial", "--joints", "100000"], "1 to 2000"),
        (&["model", "nowhere.mbs"], "cannot read"),
    ] {
        let output = robovec(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        // What is wrong with the command line alone is told before anything runs.
        let code = if words == "1 to 2000" { 2 } else { 1 };
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        assert!(message.contains(words), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
    }
}

/// The table of trees in the README is counted again.
#[test]
fn the_table_of_trees_is_right() {
    let text = fs::read_to_string(root().join("examples/models/README.md")).expect("it is there");
    let rows = text.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let stem = cells.get(1)?.strip_prefix('`')?.strip_suffix(".mbs`")?;
        (cells.len() == 8).then(|| (stem.to_owned(), cells[2..7].join(" | ")))
    });
    let mut count = 0;
    for (stem, shown) in rows {
        let (family, joints) = family_of(&stem);
        let joints = joints.or(family.joints()).expect("a number");
        let model = family.build(joints, 1);
        let depths: Vec<usize> = (0..joints)
            .map(|joint| model.path(Some(joint)).count())
            .collect();
        let row: Vec<&str> = shown.split(" | ").collect();
        assert_eq!(row[0], joints.to_string(), "{stem}");
        let longest = depths.iter().max().expect("a joint").to_string();
        assert_eq!(row[3], longest, "{stem}");
        assert_eq!(row[4], depths.iter().sum::<usize>().to_string(), "{stem}");
        count += 1;
    }
    assert_eq!(count, 16);
}

/// The hand-written files of the suspension belong to the model of the quarter
/// car, in all languages; only their sensors are numbered otherwise.
#[test]
fn stale_equations_are_told_from_fresh_ones() {
    let model = "examples/models/quarter-car.mbs";
    let kinds = [
        "dirdyna",
        "invdyna",
        "cons_hJ",
        "cons_jdqd",
        "link",
        "extforces",
    ];
    let mut arguments = vec![
        "model".to_owned(),
        model.to_owned(),
        "--equations".to_owned(),
    ];
    for language in ["c", "m", "py"] {
        arguments.extend(
            kinds.map(|kind| format!("examples/suspension/mbs_{kind}_suspension.{language}")),
        );
    }
    let run = |arguments: &[String]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
        let output = command.current_dir(root()).args(arguments).output();
        output.expect("the program starts")
    };
    let output = run(&arguments);
    let (said, complaints) = (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    );
    assert_eq!(output.status.code(), Some(0), "{complaints}");
    assert_eq!(complaints, "");
    assert_eq!(said.matches("belongs to the model").count(), 18, "{said}");
    arguments.push("examples/suspension/mbs_sensor_suspension.c".to_owned());
    let output = run(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(
        complaints.contains("'sensor_1' does not use dpt[2,3]"),
        "{complaints}"
    );
    // One file that is none does not keep the others from being compared.
    let mut mixed = arguments[..4].to_vec();
    mixed.insert(3, "examples/suspension/README.md".to_owned());
    let output = run(&mixed);
    let said = String::from_utf8_lossy(&output.stdout);
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("belongs to the model: dirdyna"), "{said}");
    assert!(
        complaints.contains("1 of 2 files cannot be compared"),
        "{complaints}"
    );
}
