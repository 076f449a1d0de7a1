//! The numbers that are tried at a limit.

use robovec_num::limits::{Amount, NumberLimit};

/// Numbers that are allowed, the extremes first.
pub(crate) fn inside(limit: &NumberLimit) -> Vec<String> {
    let middle = if limit.is_whole() {
        vec![Amount::Whole(0), Amount::Whole(1), Amount::Whole(2)]
    } else {
        [0.0, f64::MIN_POSITIVE / 2.0, 1e-30, -1.0, 1.0]
            .map(Amount::Real)
            .to_vec()
    };
    let mut values = vec![limit.most().to_string(), limit.least().to_string()];
    for amount in middle {
        let text = amount.to_string();
        if limit.admits(amount) && !values.contains(&text) {
            values.push(text);
        }
    }
    values.dedup();
    values
}

/// Texts that are not allowed: just outside, the ends of usual types, minus
/// signs, numbers that are none.
pub(crate) fn outside(limit: &NumberLimit) -> Vec<String> {
    let mut values: Vec<String> = Vec::new();
    match (limit.least(), limit.most()) {
        (Amount::Whole(least), Amount::Whole(most)) => {
            values.extend(least.checked_sub(1).map(|number| number.to_string()));
            values.extend(most.checked_add(1).map(|number| number.to_string()));
            let far = [0, u64::from(u32::MAX), u64::MAX];
            let far = far
                .into_iter()
                .filter(|&far| !(least..=most).contains(&far));
            values.extend(far.map(|number| number.to_string()));
            values.push("1.5".to_owned());
        }
        (Amount::Real(least), Amount::Real(most)) => {
            values.push(format!("{:e}", least.next_down()));
            values.push(format!("{:e}", most.next_up()));
            let far = [0.0, -1.0, 1e308, 1e-300, f64::MIN_POSITIVE / 4.0];
            let far = far.into_iter().filter(|far| !(least..=most).contains(far));
            values.extend(far.map(|number| format!("{number:e}")));
        }
        _ => unreachable!("both ends are of one kind"),
    }
    if limit.is_whole() {
        values.push("-1".to_owned());
    }
    values.extend(["18446744073709551616", "1e309", "nan", "inf", "-inf"].map(str::to_owned));
    values.retain(|text| match text.parse::<f64>() {
        Ok(number) => !limit.admits(Amount::Real(number)),
        Err(_) => true,
    });
    let mut seen = std::collections::BTreeSet::new();
    values.retain(|text| seen.insert(text.clone()));
    values
}
