//! Proves or refutes the rules of a file.
//!
//!     cargo run -p robovec-rules --example prove -- rules/trigonometry.rules

use robovec_rules::RuleSet;
use robovec_rules::check::check;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("a file")?;
    let text = std::fs::read_to_string(&path)?;
    let rules = RuleSet::parse(&text, &path).map_err(|report| report.render_plain())?;
    for rule in &rules.rules {
        let finding = check(rule, 1000);
        let word = if finding.is_sound() {
            "proved"
        } else {
            "not proved"
        };
        println!("{:24} {word}, {}", rule.name, finding.class);
    }
    Ok(())
}
