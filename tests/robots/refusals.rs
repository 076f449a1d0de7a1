//! Wrong files: every mistake is reported with its place and a remedy, no file
//! is written, and no file takes long.

use super::shipped::EXAMPLES;
use crate::support::files::{compare_with_record, each, list, name, tree};
use crate::support::programs::robovec;
use robovec::generate::{Formulation, GenerateError, GenerationRequest, generate};
use robovec::model::robot::{RobotBase, read_robot};
use robovec::robotran::FunctionKind;
use robovec::robotran::conventions::JOINT_LIMIT;
use std::fs;
use std::path::Path;

const ERRORS: &str = "tests/robots/errors";

#[test]
fn mistakes_are_told_with_place_and_advice() {
    each(ERRORS, &["urdf", "xml"], |path| {
        let bytes = fs::read(path).expect("it can be read");
        let name = name(path);
        let shown = match read_robot(&name, &bytes, RobotBase::Fixed) {
            Ok(read) if read.warnings.is_empty() => panic!("{name}: nothing is wrong"),
            Ok(read) => read.warnings.render_plain(),
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
fn a_refused_robot_exits_with_1_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let result = folder.path().join("result");
    let result = result.to_str().expect("a plain name");
    for path in list(ERRORS, &["urdf", "xml"]) {
        let bytes = fs::read(&path).expect("it can be read");
        if read_robot("r", &bytes, RobotBase::Fixed).is_ok() {
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

/// A free base without mass is reported if and only if no accelerations are
/// determined: with one other link, but not with two or a rotor.
#[test]
fn a_free_base_without_mass_is_reported_where_the_masses_are_singular() {
    let file = |name: &str| {
        let path = tree("examples/robots").join(name);
        fs::read_to_string(path).expect("it can be read")
    };
    let arm = "<joint name='NAME' type='revolute'><parent link='base'/><child link='of-NAME'/>\
               <origin xyz='PLACE 0 0' rpy='0 PLACE 0'/>DRIVE</joint>\
               <link name='of-NAME'><inertial><mass value='1'/>\
               <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>";
    let arms = |places: &[&str], drive: &str| {
        let arms = places.iter().map(|place| {
            let arm = arm.replace("NAME", &format!("arm{place}"));
            arm.replace("PLACE", place).replace("DRIVE", drive)
        });
        let arms: String = arms.collect();
        format!("<robot name='r'><link name='base'/>{arms}</robot>")
    };
    let rotor = "<dynamics armature='0.1'/>";
    let made = [arms(&["1"], ""), arms(&["1"], rotor), arms(&["1", "2"], "")];
    let robots = EXAMPLES.into_iter().map(file).chain(made);
    let reported = robots.map(|text| {
        let read = read_robot("r.urdf", text.as_bytes(), RobotBase::Floating).expect("a robot");
        let warnings = read.warnings.render_plain();
        let request = GenerationRequest {
            formulation: Formulation::Composite,
            ..GenerationRequest::new(FunctionKind::Accelred)
        };
        let is_singular = match generate(&read.model, &request) {
            Ok(_) => false,
            Err(GenerateError::Singular { .. }) => true,
            Err(error) => panic!("{error}"),
        };
        assert_eq!(
            warnings.contains("without mass"),
            is_singular,
            "{warnings}{text}"
        );
        is_singular
    });
    let expected = [true, true, true, false, true, false, false];
    assert_eq!(reported.collect::<Vec<bool>>(), expected);
}

/// The message for a robot with this text inside.
fn refusal(inside: &str) -> String {
    refusal_of(format!("<robot name='r'>{inside}</robot>").as_bytes())
}

fn refusal_of(text: &[u8]) -> String {
    match read_robot("hostile.urdf", text, RobotBase::Floating) {
        Ok(_) => panic!("it is accepted"),
        Err(error) => {
            let shown = error.report.render_plain();
            assert!(shown.len() < 50_000, "a message of {} bytes", shown.len());
            shown
        }
    }
}

/// Links `l0` to `l(count)`, each but the first on a joint to another one.
fn chain(count: usize, kind: &str, parent: impl Fn(usize) -> usize, inside: &str) -> String {
    let mut text: String = (0..=count)
        .map(|n| format!("<link name='l{n}'/>"))
        .collect();
    for n in 1..=count {
        text += &format!(
            "<joint name='j{n}' type='{kind}'><parent link='l{}'/><child link='l{n}'/>{}</joint>",
            parent(n),
            inside.replace("NEXT", &(n % count + 1).to_string())
        );
    }
    text
}

#[test]
fn huge_and_hostile_files_are_refused_in_time() {
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    let shown = refusal_of(deep.as_bytes());
    assert!(shown.contains("not a robot"), "{shown}");
    // What is passed over may be nested as deep as it likes.
    assert!(refusal(&deep).contains("the robot has no link"));
    let open = "<robot>".repeat(100_000);
    assert!(refusal_of(open.as_bytes()).contains("cut short"));
    let attributes: String = (0..100_000).map(|n| format!(" a{n}=''")).collect();
    let shown = refusal_of(format!("<robot{attributes}/>").as_bytes());
    assert!(shown.contains("too many attributes"), "{shown}");
    let long = chain(20_000, "revolute", |n| n - 1, "");
    let shown = refusal(&long);
    assert!(shown.contains("20000 is not allowed"), "{shown}");
    assert!(shown.contains(&JOINT_LIMIT.to_string()), "{shown}");
    // Each floating joint is six joints of the model.
    let floating = chain(JOINT_LIMIT / 6 + 1, "floating", |_| 0, "");
    assert!(refusal(&floating).contains("is not allowed"));
    // Work that grows with the square of the file would take minutes here.
    let circle = chain(
        20_000,
        "revolute",
        |n| if n == 1 { 20_000 } else { n - 1 },
        "",
    );
    assert!(refusal(&circle).contains("is on a cycle"));
    let follows = chain(JOINT_LIMIT, "revolute", |n| n - 1, "<mimic joint='jNEXT'/>");
    assert!(refusal(&follows).contains("follows itself"));
    let same = "<link name='l'/>".repeat(100_000);
    assert!(refusal(&same).contains("there are more"));
    let lost = "<joint name='j' type='fixed'><parent link='x'/><child link='y'/></joint>";
    assert!(refusal(&lost.repeat(50_000)).contains("there are more"));
    assert!(refusal_of(&[0, 159, 146, 150]).contains("not text"));
    assert!(refusal_of(b"").contains("no element"));
}

/// A property for which `.mbs` files have no words is refused with the joint
/// and the reason, and the rest is read back as the same model.
#[test]
fn a_robot_is_written_as_mbs_where_that_can_say_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let reasons = [
        ("arm.urdf", Some("joint 'joint_4' moves against its axis")),
        ("gripper.urdf", Some("joint 'left_finger_joint' is turned")),
        ("oblique.urdf", Some("joint 'lean' is turned")),
        ("quadruped.urdf", None),
    ];
    assert_eq!(reasons.map(|(name, _)| name), EXAMPLES);
    for (name, reason) in reasons {
        let result = folder.path().join(name).with_extension("mbs");
        let written = result.to_str().expect("a plain name");
        let path = format!("examples/robots/{name}");
        let output = robovec(&["model", &path, "-o", written]);
        let message = String::from_utf8_lossy(&output.stderr);
        let Some(reason) = reason else {
            assert!(output.status.success(), "{message}");
            let [again, before] = [written, path.as_str()].map(|path| {
                let output = robovec(&["gen", path, "--function", "dirdyna"]);
                assert!(output.status.success(), "{path}");
                output.stdout
            });
            assert!(again == before, "{name}: other equations");
            continue;
        };
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        assert!(message.contains(reason), "{name}: {message}");
        assert!(!result.exists());
    }
}
