//! Files with the signatures that MBsysC calls.

use robovec_ir::{Function, Module, View};

/// A read file that can be called.
pub(super) struct Callable {
    /// Its place among the subjects.
    pub(super) subject: usize,
    pub(super) module: Module,
    /// The function as the file names it.
    pub(super) function: String,
}

/// Calls as MBsysC makes them: one function of a known kind, whole.
pub(super) fn callable(
    subject: usize,
    module: Module,
    text: &str,
    extent: u32,
) -> Option<Callable> {
    let first = module.functions.first()?;
    let part = |function: &Function| function.metadata.iter().any(|(key, _)| key == "part");
    let kind = kind_of(first);
    if module.functions.iter().any(part) || module.functions.iter().any(|f| kind_of(f) != kind) {
        return None;
    }
    let small = |view: View<'_>| {
        let arrays = view.function.inputs().iter().chain(view.function.outputs());
        arrays.into_iter().all(|array| {
            let (indices, _) = match array.shape.len() {
                0 => ([0, 0], 0),
                length => array.shape.indices(length as u32 - 1),
            };
            indices.iter().all(|&index| index < extent)
        })
    };
    let tables = &module.tables;
    let all_small = module
        .functions
        .iter()
        .all(|function| small(View { tables, function }));
    let prefixed = format!("mbs_{kind}");
    let function = if text.contains(&prefixed) {
        prefixed
    } else {
        kind
    };
    (all_small && call_of(&function).is_some()).then_some(Callable {
        subject,
        module,
        function,
    })
}

/// `sensor` for `sensor_3`.
pub(super) fn kind_of(function: &Function) -> String {
    let case = function.metadata.iter().find(|(key, _)| key == "case");
    match case {
        Some((_, number)) => function
            .name
            .trim_end_matches(&format!("_{number}"))
            .to_owned(),
        None => function.name.clone(),
    }
}

pub(super) fn case_of(function: &Function) -> u32 {
    let case = function.metadata.iter().find(|(key, _)| key == "case");
    case.map_or(1, |(_, number)| number.parse().expect("a number"))
}

/// Call of a function by MBsysC.
pub(super) fn call_of(function: &str) -> Option<&'static str> {
    Some(match function.strip_prefix("mbs_").unwrap_or(function) {
        "dirdyna" => "(s->M, s->c, s, tsim)",
        "invdyna" => "(s->Qq, s, tsim)",
        "cons_hJ" => "(s->h, s->Jac, s, tsim)",
        "cons_jdqd" => "(s->Jdqd, s, tsim)",
        "link" => "(s->frc, s->trq, s->Flink, s->Z, s->Zd, s, tsim)",
        "link3D" | "extforces" => "(s->frc, s->trq, s, tsim)",
        "sensor" | "gensensor" => "(sens, s, isens)",
        "accelred" | "invdynared" | "dirdyna_odn" => "(s, tsim)",
        _ => return None,
    })
}
