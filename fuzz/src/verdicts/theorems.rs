//! Random instances of theorems.

use super::parsed;
use arbitrary::{Result, Unstructured};
use robovec_rules::Rule;

/// Theorems in `X`, `Y` and `Z`, which may be any terms, in numbers `K` and
/// `L`, and in `p`, `q` and `n`, which must be positive and, `n`, not zero.
const THEOREMS: &[&str] = &[
    // Rings.
    "X*(Y + Z) => X*Y + X*Z",
    "X*Y - X*Z => X*(Y - Z)",
    "(X + Y)*(X - Y) => X*X - Y*Y",
    "(X + K)*(X - K) => X*X - K*K",
    "(X + Y)*(X + Y) => X*X + 2*X*Y + Y*Y",
    "(X - K*Y)*(X + L*Y) => X*X + (L - K)*X*Y - K*L*Y*Y",
    "X - (Y - Z) => X + Z - Y",
    "(X + Y) - (Y - K) => X + K",
    "X*X*X - Y*Y*Y => (X - Y)*(X*X + X*Y + Y*Y)",
    "K*X + L*X => (K + L)*X",
    "-(X - K*Y) => K*Y - X",
    "X*Y + X + Y + 1 => (X + 1)*(Y + 1)",
    "0.5*(X + Y)*(X + Y) - 0.5*(X - Y)*(X - Y) => 2*X*Y",
    // Fractions.
    "X/Z + Y/Z => (X + Y)/Z",
    "X/Y/Z => X/(Y*Z)",
    "X/(Y/Z) => X*Z/Y",
    "X/Y*Y => X + 0",
    "X/Y - Z/Y => (X - Z)/Y",
    "(X*X - Y*Y)/(X - Y) => X + Y",
    "1/X + 1/Y => (X + Y)/(X*Y)",
    "1/(X - Y) - 1/(X + Y) => 2*Y/(X*X - Y*Y)",
    "1/(X - K) => 2/(2*X - 2*K)",
    "X/(Y*Y + 1) + 0*Z => X*(Z*Z + 2)/((Y*Y + 1)*(Z*Z + 2))",
    "X + 0*n => X*n/n",
    "X/p + Y/q => (X*q + Y*p)/(p*q)",
    "(X + Y)*(p + q) => (X + Y)/(1/(p + q))",
    "X/(p + K*K) => X*p/(p*p + K*K*p)",
    "(X*n + Y*n)/n => X + Y",
    "X/X => 1",
    "K/(X/L) => K*L/X",
    "X/K + Y/K => (X + Y)/K",
    "X/(1/Y + 1/Z) => X*Y*Z/(Y + Z)",
    // Roots.
    "sqrt(X)*sqrt(X) => X + 0",
    "sqrt(p*p) => p + 0",
    "sqrt(p*q) => sqrt(p)*sqrt(q)",
    "sqrt(p/q) => sqrt(p)/sqrt(q)",
    "sqrt(p*p*q) => p*sqrt(q)",
    "1/sqrt(X) => sqrt(X)/X",
    "sqrt(4*X) => 2*sqrt(X)",
    "sqrt(X*X)*sqrt(Y*Y) => sqrt(X*X*Y*Y)",
    "sqrt((X - Y)*(X - Y)) => sqrt((Y - X)*(Y - X))",
    "sqrt(p*p + 2*p*q + q*q) => p + q",
    "sqrt((X*X + 1)*(X*X + 1)) => X*X + 1",
    "(sqrt(p) - sqrt(q))*(sqrt(p) + sqrt(q)) => p - q",
    "sqrt(K*K*p) => sqrt(K*K)*sqrt(p)",
    "sqrt((p + 1)*(p + 1)) => p + 1",
    "X/sqrt(p*p) => X/p",
    "sqrt(X*X + Y*Y)*sqrt(X*X + Y*Y) => X*X + Y*Y",
    "sqrt((X - K)*(X - K)) => sqrt((K - X)*(K - X))",
    // Angles.
    "sin(X)*sin(X) + cos(X)*cos(X) => 1",
    "sin(-X) => -sin(X)",
    "cos(Y - X) => cos(X - Y)",
    "sin(X + Y) => sin(X)*cos(Y) + cos(X)*sin(Y)",
    "cos(X + Y) => cos(X)*cos(Y) - sin(X)*sin(Y)",
    "sin(X)*cos(Y) - cos(X)*sin(Y) => sin(X - Y)",
    "cos(X - K*Y) => cos(X)*cos(K*Y) + sin(X)*sin(K*Y)",
    "sin(2*X) => 2*sin(X)*cos(X)",
    "cos(2*X) => 1 - 2*sin(X)*sin(X)",
    "cos(X) => cos(0.5*X)*cos(0.5*X) - sin(X/2)*sin(X/2)",
    "sin(3*X) => 3*sin(X) - 4*sin(X)*sin(X)*sin(X)",
    "2*sin(X)*sin(Y) => cos(X - Y) - cos(X + Y)",
    "sin(1.5*X) => sin(X)*cos(X*0.5) + cos(X)*sin(0.5*X)",
    "(1 + cos(2*X))/2 => cos(X)*cos(X)",
    "sin(X + Y)/(cos(X)*cos(Y)) => sin(X)/cos(X) + sin(Y)/cos(Y)",
    "1 - sin(X)*sin(X) => cos(X)*cos(X)",
    "sqrt(1 - cos(X)*cos(X)) => sqrt(sin(X)*sin(X))",
    "Y/(1 - sin(X)*sin(X)) => Y/(cos(X)*cos(X))",
    "cos(X)*(cos(X)*Y - sin(X)*Z) + sin(X)*(sin(X)*Y + cos(X)*Z) => Y + 0*Z",
    "sin(X)*Y + sin(X)*Z => sin(X)*(Y + Z)",
    "Y/(2 + cos(X)) => Y*(3 + sin(X))/((2 + cos(X))*(3 + sin(X)))",
];

/// Numbers: whole and broken, huge and tiny, powers of two about 61.
const NUMBERS: &str = "1 2 3 5 7 9 12 100 538 1031 0.5 0.25 1.5 0.1 0.3 2.7 9.81 0.001 1e-9 \
    1e6 1e9 123456.789 2305843009213693952 4611686018427387904 4.336808689942018e-19 \
    2147483648 1e-30 1e30 1e100 1e-100 1e-300 1e300";

/// A number that occurs in programs, or a hostile one.
pub(super) fn number(bytes: &mut Unstructured<'_>) -> Result<String> {
    if bytes.ratio(1, 2)? {
        return Ok(bytes.int_in_range(1..=40)?.to_string());
    }
    let numbers: Vec<&str> = NUMBERS.split(' ').collect();
    Ok((*bytes.choose(&numbers)?).to_owned())
}

/// A term without divisions, in parentheses.
fn term(bytes: &mut Unstructured<'_>, depth: u32) -> Result<String> {
    let variable =
        |bytes: &mut Unstructured<'_>| -> Result<&str> { bytes.choose(&["a", "b", "c"]).copied() };
    if depth == 0 || bytes.ratio(1, 3)? {
        return Ok(variable(bytes)?.to_owned());
    }
    Ok(match bytes.int_in_range(0..=9)? {
        0..=2 => format!(
            "({} + {})",
            term(bytes, depth - 1)?,
            term(bytes, depth - 1)?
        ),
        3..=4 => format!(
            "({} - {})",
            term(bytes, depth - 1)?,
            term(bytes, depth - 1)?
        ),
        5..=6 => format!("({}*{})", variable(bytes)?, term(bytes, depth - 1)?),
        7 => format!("({}*{})", number(bytes)?, variable(bytes)?),
        8 => format!("({} - {})", variable(bytes)?, number(bytes)?),
        _ => format!("sin({})", variable(bytes)?),
    })
}

/// A random instance of a theorem.
pub(super) fn theorem(bytes: &mut Unstructured<'_>) -> Result<Rule> {
    let theorem = *bytes.choose(THEOREMS)?;
    let mut substitutes: Vec<(char, String)> = Vec::new();
    for name in ['X', 'Y', 'Z'] {
        let depth = bytes.int_in_range(0..=2)?;
        substitutes.push((name, term(bytes, depth)?));
    }
    for name in ['K', 'L'] {
        substitutes.push((name, number(bytes)?));
    }
    let mut text = String::from("rule r: ");
    for letter in theorem.chars() {
        match substitutes.iter().find(|(name, _)| *name == letter) {
            Some((_, substitute)) => text += substitute,
            None => text.push(letter),
        }
    }
    let mut conditions = Vec::new();
    for (name, condition) in [
        ("p", "positive(p)"),
        ("q", "positive(q)"),
        ("n", "nonzero(n)"),
    ] {
        if uses(theorem, name) {
            conditions.push(condition);
        }
    }
    if !conditions.is_empty() {
        text += " when ";
        text += &conditions.join(", ");
    }
    text += " class=real-trig;";
    // The instance may be a mistake of another kind: two equal sides.
    parsed(&text).ok_or(arbitrary::Error::IncorrectFormat)
}

/// True when the text contains the name as a whole word.
fn uses(theorem: &str, name: &str) -> bool {
    theorem
        .split(|letter: char| !letter.is_ascii_alphanumeric())
        .any(|word| word == name)
}
