//! Random pipelines that can run: levels and properties fit.

use arbitrary::{Result, Unstructured};
use robovec_framework::pass::{Gives, PassInfo, Property};
use robovec_ir::Level;
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;

/// A pipeline of up to `most` passes, with random options, for a function at
/// the equations level; placement and code generation stay out, and passes
/// that are tested on their own ([`crate::precision`],
/// [`crate::derivatives`]).
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn pipeline(bytes: &mut Unstructured<'_>, most: u32) -> Result<String> {
    Ok(chosen(bytes, most, &["accurate", "mixed", "differentiate"])?.join(","))
}

/// Draws passes as [`pipeline`] does, one text for each pass; includes passes
/// that leave the function unchanged.
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn steps(bytes: &mut Unstructured<'_>, most: u32) -> Result<Vec<String>> {
    chosen(bytes, most, &["differentiate"])
}

fn chosen(bytes: &mut Unstructured<'_>, most: u32, without: &[&str]) -> Result<Vec<String>> {
    let mut steps = Vec::new();
    let mut level = Level::Equations;
    let mut properties: Vec<Property> = Vec::new();
    for _ in 0..bytes.int_in_range(1..=most)? {
        let fits = |info: &&PassInfo| {
            let kept = match info.gives {
                Gives::Same => true,
                Gives::Level(level) => level <= Level::Atomic,
            };
            kept && info.takes.contains(&level)
                && info.name != "codegen"
                && !without.contains(&info.name)
                && info
                    .requires
                    .iter()
                    .all(|wanted| properties.contains(wanted))
        };
        let choice: Vec<&PassInfo> = REGISTRY.passes.iter().filter(fits).collect();
        let info = *bytes.choose(&choice)?;
        let mut text = info.name.to_owned();
        options(bytes, info, &mut text)?;
        steps.push(text);
        if let Gives::Level(given) = info.gives {
            level = given;
        }
        properties.retain(|property| !info.destroys.contains(property));
        properties.extend(info.sets);
    }
    Ok(steps)
}

/// Some options, with values of their types.
fn options(bytes: &mut Unstructured<'_>, info: &PassInfo, text: &mut String) -> Result<()> {
    let mut chosen = Vec::new();
    for option in info.options {
        if !bytes.ratio(1, 4)? {
            continue;
        }
        let kind = (option.type_name)();
        let words: Vec<&str> = kind.split(" | ").collect();
        let value = match *bytes.choose(&words)? {
            "integer" => bytes.int_in_range(1..=4u32)?.to_string(),
            "number" => "0.5".to_owned(),
            word => word.to_owned(),
        };
        // A kind may be described by more than its words.
        if (info.build)(&[(option.name.to_owned(), value.clone())]).is_ok() {
            chosen.push(format!("{}={value}", option.name));
        }
    }
    if !chosen.is_empty() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{{{}}}", chosen.join(" "));
    }
    Ok(())
}
