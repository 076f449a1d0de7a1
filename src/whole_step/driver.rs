//! The text of `mbs_accelred`: calls in the order of MBsysC, and Newton's
//! method.

use super::StepPlan;
use robovec_codegen::kind::{Generation, ProjectStructure};
use std::fmt::Write;

/// Rounds of Newton's method before closing is given up, as in MBsysC.
const MAX_ROUNDS: usize = 100;

/// The C source.
pub(super) fn source(step: &StepPlan<'_>, stem: &str) -> String {
    let ProjectStructure {
        prefix,
        header,
        functions,
        ..
    } = step.generation.structure();
    let mut text = format!(
        "/* {prefix}accelred by robovec: the whole step of the model {stem}.\n   \
         It takes the place of Robotran's function of the same name: the motion of\n   \
         driven joints, closed loops, forces, accelerations. It returns the rounds\n   \
         that closing took, or -1 where the loops do not close or the project is\n   \
         another than the one this was made for. */\n\
         #include <math.h>\n#include <stdio.h>\n\n\
         #include \"{header}\"\n#include \"{functions}\"\n\n"
    );
    let parts: &[&str] = match step.has_loops() {
        true => &["loop_positions", "loop_velocities", "accelerations"],
        false => &["accelerations"],
    };
    for part in parts {
        let _ = writeln!(text, "#include \"mbs_{part}_{stem}.h\"");
    }
    same_project(&mut text, step);
    if step.has_loops() {
        close(&mut text, step);
    }
    forces(&mut text, step);
    step_itself(&mut text, step);
    text
}

/// A function that tells whether the project has the partition of joints that
/// the equations were made for.
fn same_project(text: &mut String, step: &StepPlan<'_>) {
    let ProjectStructure { name, prefix, .. } = step.generation.structure();
    let count = step.independent.len();
    let joints: Vec<String> = step.independent.iter().map(usize::to_string).collect();
    let list = match count {
        0 => "0".to_owned(),
        _ => joints.join(", "),
    };
    let _ = write!(
        text,
        "\n/* Whether the project has the coordinates that the equations were made for. */\n\
         static int robovec_same_project(const {name} *s)\n{{\n    \
         static const int independent[] = {{{list}}};\n    \
         int same = s->njoint == {joints_of_model} && s->nqu == {count} && s->Nuserc == 0;\n    \
         for (int i = 0; same && i < {count}; i++)\n        \
         same = s->qu[i + 1] == independent[i];\n    \
         if (!same)\n        \
         fprintf(stderr, \"{prefix}accelred: made for %d joints, of which these are independent: {list};\"\n                \
         \" the project has other ones, or constraints of its own\\n\", {joints_of_model});\n    \
         return same;\n}}\n",
        joints_of_model = step.model.joints.len(),
    );
}

/// A function that closes the loops.
fn close(text: &mut String, step: &StepPlan<'_>) {
    let ProjectStructure { name, prefix, .. } = step.generation.structure();
    let _ = write!(
        text,
        "\n/* Closes the loops; gives the rounds it took, or -1. */\n\
         static int robovec_close({name} *s, double tsim)\n{{\n    \
         double h[{words}] = {{0}};\n    \
         for (int round = 0; round <= {MAX_ROUNDS}; round++) {{\n        \
         double largest = 0;\n        \
         {prefix}loop_positions(h, s, tsim);\n        \
         for (int row = 1; row < {words}; row++) {{\n            \
         const double size = fabs(h[row]);\n            \
         /* Also what is no number at all. */\n            \
         if (!(size <= 1e300))\n                \
         return -1;\n            \
         if (size > largest)\n                \
         largest = size;\n        \
         }}\n        \
         if (largest <= s->NRerr) {{\n            \
         {prefix}loop_velocities(s, tsim);\n            \
         return round;\n        \
         }}\n    \
         }}\n    \
         return -1;\n}}\n",
        words = step.rows + 1,
    );
}

/// A function that computes forces as the library does.
fn forces(text: &mut String, step: &StepPlan<'_>) {
    let ProjectStructure { name, prefix, .. } = step.generation.structure();
    let joints = step.model.joints.len();
    let _ = write!(
        text,
        "\n/* Forces on bodies and joints. */\n\
         static void robovec_forces({name} *s, double tsim)\n{{\n    \
         for (int axis = 1; axis <= 3; axis++)\n        \
         for (int joint = 1; joint <= {joints}; joint++)\n            \
         s->frc[axis][joint] = s->trq[axis][joint] = 0;\n"
    );
    let model = step.model;
    let calls = [
        (!model.links.is_empty(), "link", ", s->Fl, s->Z, s->Zd"),
        (!model.links3d.is_empty(), "link3D", ""),
        (!model.forces.is_empty(), "extforces", ""),
    ];
    for (_, function, arrays) in calls.into_iter().filter(|(is_there, ..)| *is_there) {
        let _ = writeln!(
            text,
            "    {prefix}{function}(s->frc, s->trq{arrays}, s, tsim);"
        );
    }
    text.push_str("    s->Qq = user_JointForces(s, tsim);\n}\n");
}

/// The function that MBsysC calls. That of generator 6.6 also fills the
/// accelerations of independent joints.
fn step_itself(text: &mut String, step: &StepPlan<'_>) {
    let ProjectStructure { name, prefix, .. } = step.generation.structure();
    let is_old = step.generation == Generation::Old;
    let filled = if is_old { "double *qddu, " } else { "" };
    let _ = write!(
        text,
        "\nint {prefix}accelred({filled}{name} *s, double tsim)\n{{\n    int rounds = 0;\n    \
         if (!robovec_same_project(s))\n        return -1;\n"
    );
    if step.has_driven_joints() {
        text.push_str("    user_DrivenJoints(s, tsim);\n");
    }
    if step.has_loops() {
        text.push_str(
            "    rounds = robovec_close(s, tsim);\n    if (rounds < 0)\n        return -1;\n",
        );
    }
    let _ = write!(
        text,
        "    robovec_forces(s, tsim);\n    {prefix}accelerations(s, tsim);\n"
    );
    if is_old {
        text.push_str(
            "    for (int i = 1; i <= s->nqu; i++)\n        qddu[i] = s->qdd[s->qu[i]];\n",
        );
    }
    text.push_str("    return rounds;\n}\n");
}
