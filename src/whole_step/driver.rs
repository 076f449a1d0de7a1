//! The text of `mbs_accelred`: calls in the order of MBsysC, and Newton's
//! method.

use super::StepPlan;
use std::fmt::Write;

/// Rounds of Newton's method before closing is given up, as in MBsysC.
const MAX_ROUNDS: usize = 100;

/// The C source.
pub(super) fn source(step: &StepPlan<'_>, stem: &str) -> String {
    let mut text = format!(
        "/* mbs_accelred by robovec: the whole step of the model {stem}.\n   \
         It takes the place of Robotran's function of the same name: the motion of\n   \
         driven joints, closed loops, forces, accelerations. It returns the rounds\n   \
         that closing took, or -1 where the loops do not close or the project is\n   \
         another than the one this was made for. */\n\
         #include <math.h>\n#include <stdio.h>\n\n\
         #include \"mbs_data.h\"\n#include \"mbs_project_interface.h\"\n\n"
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
    let count = step.independent.len();
    let joints: Vec<String> = step.independent.iter().map(usize::to_string).collect();
    let list = match count {
        0 => "0".to_owned(),
        _ => joints.join(", "),
    };
    let _ = write!(
        text,
        "\n/* Whether the project has the coordinates that the equations were made for. */\n\
         static int robovec_same_project(const MbsData *s)\n{{\n    \
         static const int independent[] = {{{list}}};\n    \
         int same = s->njoint == {joints_of_model} && s->nqu == {count} && s->Nuserc == 0;\n    \
         for (int i = 0; same && i < {count}; i++)\n        \
         same = s->qu[i + 1] == independent[i];\n    \
         if (!same)\n        \
         fprintf(stderr, \"mbs_accelred: made for %d joints, of which these are independent: {list};\"\n                \
         \" the project has other ones, or constraints of its own\\n\", {joints_of_model});\n    \
         return same;\n}}\n",
        joints_of_model = step.model.joints.len(),
    );
}

/// A function that closes the loops.
fn close(text: &mut String, step: &StepPlan<'_>) {
    let _ = write!(
        text,
        "\n/* Closes the loops; gives the rounds it took, or -1. */\n\
         static int robovec_close(MbsData *s, double tsim)\n{{\n    \
         double h[{words}] = {{0}};\n    \
         for (int round = 0; round <= {MAX_ROUNDS}; round++) {{\n        \
         double largest = 0;\n        \
         int is_number = 1;\n        \
         mbs_loop_positions(h, s, tsim);\n        \
         for (int row = 1; row < {words}; row++) {{\n            \
         const double size = fabs(h[row]);\n            \
         if (!(size <= 1e300))\n                \
         is_number = 0;\n            \
         if (size > largest)\n                \
         largest = size;\n        \
         }}\n        \
         if (!is_number)\n            \
         return -1;\n        \
         if (largest <= s->NRerr) {{\n            \
         mbs_loop_velocities(s, tsim);\n            \
         return round;\n        \
         }}\n    \
         }}\n    \
         return -1;\n}}\n",
        words = step.rows + 1,
    );
}

/// A function that computes forces as the library does.
fn forces(text: &mut String, step: &StepPlan<'_>) {
    let joints = step.model.joints.len();
    let _ = write!(
        text,
        "\n/* Forces on bodies and joints. */\n\
         static void robovec_forces(MbsData *s, double tsim)\n{{\n    \
         for (int axis = 1; axis <= 3; axis++)\n        \
         for (int joint = 1; joint <= {joints}; joint++)\n            \
         s->frc[axis][joint] = s->trq[axis][joint] = 0;\n"
    );
    if !step.model.links.is_empty() {
        text.push_str("    mbs_link(s->frc, s->trq, s->Fl, s->Z, s->Zd, s, tsim);\n");
    }
    if !step.model.links3d.is_empty() {
        text.push_str("    mbs_link3D(s->frc, s->trq, s, tsim);\n");
    }
    if !step.model.forces.is_empty() {
        text.push_str("    mbs_extforces(s->frc, s->trq, s, tsim);\n");
    }
    text.push_str("    s->Qq = user_JointForces(s, tsim);\n}\n");
}

/// The function that MBsysC calls.
fn step_itself(text: &mut String, step: &StepPlan<'_>) {
    text.push_str(
        "\nint mbs_accelred(MbsData *s, double tsim)\n{\n    int rounds = 0;\n    \
         if (!robovec_same_project(s))\n        return -1;\n",
    );
    if step.has_driven_joints() {
        text.push_str("    user_DrivenJoints(s, tsim);\n");
    }
    if step.has_loops() {
        text.push_str(
            "    rounds = robovec_close(s, tsim);\n    if (rounds < 0)\n        return -1;\n",
        );
    }
    text.push_str(
        "    robovec_forces(s, tsim);\n    mbs_accelerations(s, tsim);\n    return rounds;\n}\n",
    );
}
