//! The laws of model files.

use arbitrary::{Arbitrary, Result, Unstructured};
use robovec::model::build::{BASE, BodyPlace, ModelBuilder};
use robovec::model::mbs::{read_mbs, write_mbs};
use robovec::model::{Asks, CutKind, JointKind, Model, Nature, UserModel};
use robovec_ir::diagnostic::Report;

/// Reads arbitrary bytes: the reader neither panics nor hangs, its messages
/// point into the text, and a model that it accepts is sound and unchanged
/// after it is written and read again.
///
/// # Panics
///
/// Panics when a law is broken.
pub fn read_model(data: &[u8]) {
    match read_mbs("fuzz.mbs", data) {
        Ok(read) => {
            check_round_trip(&read.model);
            assert!(read.warnings.render_plain().len() < 200_000);
        }
        Err(error) => check_refusal(&error.report),
    }
}

/// A refusal gives a reason, with places inside the text, and at most a
/// readable number of messages.
pub(crate) fn check_refusal(report: &Report) {
    assert!(report.has_errors(), "a refusal gives a reason");
    let files = report.files();
    let labels = report.diagnostics().iter().flat_map(|error| &error.labels);
    for label in labels {
        let length = files[label.file_id].text().len();
        assert!(label.range.start <= label.range.end && label.range.end <= length);
    }
    let shown = report.render_plain();
    assert!(shown.len() < 200_000, "{} bytes of messages", shown.len());
}

/// A random model with every kind of element: it is unchanged after it is
/// written and read.
///
/// # Panics
///
/// Panics when a law is broken.
pub fn model_round_trip(data: &[u8]) {
    // Too few bytes are no finding.
    let _ = check_random(&mut Unstructured::new(data));
}

fn check_random(bytes: &mut Unstructured<'_>) -> Result<()> {
    check_round_trip(&model(bytes)?);
    Ok(())
}

/// A model is unchanged after it is written and read.
pub(crate) fn check_round_trip(model: &Model) {
    assert!(model.check());
    let text = write_mbs(model);
    match read_mbs("written.mbs", text.as_bytes()) {
        Ok(again) => {
            assert!(again.model == *model, "this reads otherwise:\n{text}");
            assert_eq!(write_mbs(&again.model), text);
        }
        Err(error) => panic!(
            "what was written is refused:\n{}",
            error.report.render_plain()
        ),
    }
}

/// A name with odd letters; its number sets it apart from others.
fn name(bytes: &mut Unstructured<'_>, number: usize) -> Result<String> {
    let mut name = String::new();
    for _ in 0..bytes.int_in_range(0..=3)? {
        let letters = [
            'a',
            '&',
            '<',
            '>',
            '"',
            '\'',
            ']',
            ';',
            'é',
            ' ',
            '\u{1f6b2}',
            '/',
        ];
        name.push(*bytes.choose(&letters)?);
    }
    Ok(format!("{number}{name}_"))
}

fn number(bytes: &mut Unstructured<'_>) -> Result<f64> {
    let any: f64 = bytes.arbitrary()?;
    // Numbers of models are limited, so that their products are numbers.
    Ok(if any.is_finite() {
        any.clamp(-1e30, 1e30)
    } else {
        1.5
    })
}

fn triple(bytes: &mut Unstructured<'_>) -> Result<[f64; 3]> {
    Ok([number(bytes)?, number(bytes)?, number(bytes)?])
}

fn asks(bytes: &mut Unstructured<'_>) -> Result<Asks> {
    let mut asks = Asks::default();
    for name in Asks::NAMES {
        if let Some(field) = asks.field(name) {
            *field = bytes.arbitrary()?;
        }
    }
    Ok(asks)
}

/// A random model.
fn model(bytes: &mut Unstructured<'_>) -> Result<Model> {
    let mut builder = ModelBuilder::new(&format!("m{}", u8::arbitrary(bytes)?));
    builder.gravity(triple(bytes)?);
    let mut places: Vec<BodyPlace> = vec![BASE.origin()];
    let mut points = Vec::new();
    let bodies = bytes.int_in_range(1..=6)?;
    for index in 0..bodies {
        let on = *bytes.choose(&places)?;
        let mut kinds = Vec::new();
        for _ in 0..bytes.int_in_range(1..=4)? {
            kinds.push(*bytes.choose(&JointKind::ALL)?);
        }
        let body = builder.body(&name(bytes, index)?, on, &kinds);
        for joint in 0..kinds.len() {
            let initial = triple(bytes)?;
            let joint = builder.joint(body, joint);
            joint.initial = initial;
            joint.nature = *bytes.choose(&Nature::ALL)?;
            joint.actuated = bytes.arbitrary()?;
            if joint.nature == Nature::Driven {
                (joint.has_velocity, joint.has_acceleration) = bytes.arbitrary()?;
            }
        }
        let (a, b) = (triple(bytes)?, triple(bytes)?);
        let inertia = [a[0], a[1], a[2], b[0], b[1], b[2]];
        let mass = number(bytes)?.abs();
        builder.mass(body, mass, triple(bytes)?, inertia);
        let owner = if bytes.ratio(1, 4)? { BASE } else { body };
        for point in 0..bytes.int_in_range(0..=2)? {
            let name = name(bytes, 10 * index + point)?;
            points.push(builder.point(owner, &name, triple(bytes)?));
        }
        places.push(body.origin());
        places.extend(&points);
    }
    // Of points only: `origin` is a name, not a place of its own.
    for (index, &point) in points.iter().enumerate() {
        if bytes.arbitrary()? {
            builder.sensor(&name(bytes, index)?, point, asks(bytes)?);
        }
        if bytes.arbitrary()? {
            builder.force(&name(bytes, index)?, point, asks(bytes)?);
        }
    }
    for index in 0..bytes.int_in_range(0..=3)? {
        let ends = [*bytes.choose(&places)?, *bytes.choose(&places)?];
        let name = name(bytes, index)?;
        match bytes.int_in_range(0..=4)? {
            0 => builder.cut(&name, CutKind::Ball, ends),
            1 => {
                let length = number(bytes)?.abs().max(f64::MIN_POSITIVE);
                builder.cut(&name, CutKind::Rod(length), ends);
            }
            2 => builder.cut(&name, CutKind::Solid, ends),
            3 => builder.link(&name, ends),
            _ => builder.link3d(&name, ends),
        }
    }
    let mut model = builder.finish();
    for cut in &mut model.cuts {
        if cut.kind == CutKind::Ball {
            cut.ignore = [bytes.arbitrary()?, bytes.arbitrary()?, false];
        }
    }
    if bytes.arbitrary()? {
        let values = vec![number(bytes)?, number(bytes)?];
        model.user_models.push(UserModel {
            name: name(bytes, 0)?,
            parameters: vec![(name(bytes, 1)?, "vector".to_owned(), values)],
        });
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    /// Pieces that bytes alone would take long to find.
    const PIECES: [&str; 40] = [
        "<mbsDescR7>",
        "</mbsDescR7>",
        "<mbsname>m</mbsname>",
        "<base>",
        "</base>",
        "<gravity><coordinates><z>-9.81</z></coordinates></gravity>",
        "<bodytree>",
        "</bodytree>",
        "<body>",
        "</body>",
        "<bodyname>A</bodyname>",
        "<bodyname>base</bodyname>",
        "<parent><bodyname>base</bodyname><pointname>origin</pointname></parent>",
        "<parent><bodyname>A</bodyname><pointname>P</pointname></parent>",
        "<joint><jointname>J</jointname><type>R1</type><nature>independent</nature></joint>",
        "<joint><jointname>K</jointname><type>T3</type><nature>driven</nature><symbols><q/></symbols></joint>",
        "<joint>",
        "</joint>",
        "<mass>1.0</mass>",
        "<mass>NaN</mass>",
        "<inertia><Ixx>1</Ixx><Ixy>1e300</Ixy></inertia>",
        "<com><coordinates><x>1</x></coordinates></com>",
        "<point><pointname>P</pointname><coordinates/></point>",
        "<point>",
        "</point>",
        "<pointname></pointname>",
        "<sensor name=\"S\" Pos=\"true\"/>",
        "<extforce name=\"F\" Jac=\"maybe\"/>",
        "<cuts>",
        "</cuts>",
        "<rod><name>R</name><endpoint1><bodyname>A</bodyname><pointname>P</pointname></endpoint1>",
        "<endpoint2><bodyname>base</bodyname><pointname>origin</pointname></endpoint2><length>1</length></rod>",
        "<ball>",
        "<ignore><x/></ignore>",
        "<links><link3D/></links>",
        "<user_models><user_model><name>U</name></user_model></user_models>",
        "<!DOCTYPE a [<!ENTITY b \"c\">]>",
        "&b;",
        "<![CDATA[A]]>",
        "<!-- c -->",
    ];

    #[test]
    fn random_models_round_trip() {
        let mut whole = 0;
        cases::of_sizes(500, 4096, |bytes| {
            check_random(bytes)?;
            whole += 1;
            Ok(())
        });
        assert!(whole > 400, "only {whole} models had bytes enough");
    }

    #[test]
    fn any_bytes_are_read_or_refused() {
        cases::of_sizes(300, 500, |bytes| {
            let length = bytes.len();
            read_model(bytes.bytes(length)?);
            Ok(())
        });
    }

    #[test]
    fn elements_in_any_order_are_read_or_refused() {
        cases::of_sizes(2000, 200, |bytes| {
            let mut text = String::from("<mbsDescR7><bodytree>");
            for _ in 0..bytes.int_in_range(1..=40)? {
                text.push_str(bytes.choose(&PIECES)?);
            }
            text.push_str("</bodytree></mbsDescR7>");
            read_model(text.as_bytes());
            Ok(())
        });
    }

    /// Damaged sound text finds more faults than random bytes.
    #[test]
    fn damaged_models_are_read_or_refused() {
        let mut accepted = 0;
        cases::of_sizes(1500, 3000, |bytes| {
            let mut text = write_mbs(&model(bytes)?).into_bytes();
            cases::damage(bytes, &mut text, 3, 60)?;
            accepted += u32::from(read_mbs("m", &text).is_ok());
            read_model(&text);
            Ok(())
        });
        assert!(accepted > 0, "all damage was refused, so little was tried");
    }
}
