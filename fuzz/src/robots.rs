//! The laws of the reader of robots (URDF, MJCF).

use crate::models::{check_refusal, check_round_trip};
use robovec::model::JointLaw;
use robovec::model::mbs::unsayable;
use robovec::model::robot::{self, RobotBase};

/// Reads arbitrary bytes, on both bases: the reader neither panics nor hangs,
/// its messages point into the text, and an accepted robot is sound; where a
/// `.mbs` file can express it, it is read back from one, except for limits, laws
/// and rotors of joints and the names of frames.
///
/// # Panics
///
/// Panics when a law is broken.
pub fn read_robot(data: &[u8]) {
    let read = [RobotBase::Fixed, RobotBase::Floating].map(|base| {
        let read = robot::read_robot("fuzz.urdf", data, base)
            .map_err(|error| check_refusal(&error.report));
        let Ok(read) = read else { return None };
        assert!(read.model.check());
        assert!(read.warnings.render_plain().len() < 200_000);
        if unsayable(&read.model).is_none() {
            let mut plain = read.model.clone();
            for joint in &mut plain.joints {
                joint.limits = None;
                joint.law = JointLaw::default();
                joint.armature = 0.0;
            }
            plain.frames.clear();
            check_round_trip(&plain);
        }
        Some(read.model.joints.len())
    });
    // Six joints more are all that a free base can be refused for; an MJCF file
    // has its free joints itself.
    if let [Some(fixed), Some(floating)] = read {
        assert!(floating == fixed + 6 || floating == fixed && is_mjcf(data));
    }
    assert!(read[0].is_some() || read[1].is_none());
}

fn is_mjcf(data: &[u8]) -> bool {
    String::from_utf8_lossy(data).contains("<mujoco")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use arbitrary::{Result, Unstructured};

    /// Pieces that bytes alone would take long to find.
    const PIECES: [&str; 34] = [
        "<link name='a'/>",
        "<link name='b'/>",
        "<link name='base'/>",
        "<link name='c'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>",
        "<link name='d'><inertial><origin xyz='1 2 3' rpy='1 1 1'/><mass value='1e9'/><inertia ixx='1' ixy='.1' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>",
        "</link>",
        "<link",
        "<joint name='j' type='revolute'>",
        "<joint name='k' type='continuous'><parent link='a'/><child link='b'/>",
        "<joint name='l' type='prismatic'><parent link='b'/><child link='c'/>",
        "<joint name='m' type='fixed'><parent link='c'/><child link='d'/></joint>",
        "<joint name='n' type='floating'><parent link='a'/><child link='c'/></joint>",
        "<joint name='origin' type='planar'><parent link='a'/><child link='base'/></joint>",
        "</joint>",
        "<parent link='base'/>",
        "<child link='a'/>",
        "<parent link='a'/><child link='b'/>",
        "<child link='c'/>",
        "<axis xyz='0 0 -1'/>",
        "<axis xyz='1e-300 1e-301 0'/>",
        "<axis xyz='0 0 0'/>",
        "<axis xyz='0.6 0 0.8'/>",
        "<origin rpy='1.57079632679 0 0'/>",
        "<origin xyz='1e30 -1e30 1e-30' rpy='3 -1 1e9'/>",
        "<mimic joint='j'/>",
        "<mimic joint='k' multiplier='1e200' offset='-1e200'/>",
        "<limit lower='-1' upper='1'/>",
        "<limit lower='1' upper='-1'/>",
        "<inertial>",
        "</inertial>",
        "<mass value='0'/>",
        "<!-- c -->",
        "<gazebo><x/></gazebo>",
        "&lt;",
    ];

    /// A robot that is sound: a tree of links with all that files can state.
    fn sound(bytes: &mut Unstructured<'_>) -> Result<Vec<u8>> {
        let mut text = String::from("<robot name='r'><link name='l0'/>");
        let kinds = [
            "revolute",
            "continuous",
            "prismatic",
            "fixed",
            "floating",
            "planar",
        ];
        let numbers = ["0", "1", "-1", "0.3", "-2e-3", "1.5707963267948966", "1e6"];
        let mut leader = String::new();
        for index in 1..=bytes.int_in_range(1..=9)? {
            let parent = bytes.int_in_range(0..=index - 1)?;
            let kind = bytes.choose(&kinds)?;
            let mut number = || bytes.choose(&numbers);
            let (x, y, roll, pitch) = (number()?, number()?, number()?, number()?);
            let mass = ["0", "1.5"][usize::from(bytes.arbitrary::<bool>()?)];
            text += &format!(
                "<link name='l{index}'><inertial><origin xyz='{x} 0 {y}'/><mass value='{mass}'/>\
                 <inertia ixx='1' ixy='0.1' ixz='0' iyy='1' iyz='-0.1' izz='1'/></inertial></link>\
                 <joint name='j{index}' type='{kind}'><parent link='l{parent}'/>\
                 <child link='l{index}'/><origin xyz='{y} {x} 0' rpy='{roll} {pitch} {x}'/>\
                 <axis xyz='{x} 1 {roll}'/><limit lower='-1' upper='2'/>{leader}</joint>"
            );
            leader = match *kind {
                "revolute" | "prismatic" => format!("<mimic joint='j{index}' multiplier='{x}'/>"),
                _ => String::new(),
            };
        }
        Ok((text + "</robot>").into_bytes())
    }

    /// Pieces of MJCF.
    const MJCF_PIECES: [&str; 34] = [
        "<body name='a' pos='1 0 0'>",
        "<body quat='1 2 3 4' childclass='c'>",
        "<body>",
        "</body>",
        "</body>",
        "</body>",
        "</body></body>",
        "<frame euler='10 20 30' pos='0 0 1'>",
        "</frame>",
        "<joint name='j'/>",
        "<joint name='k' type='slide' axis='1 1 0' ref='0.5' pos='1 2 3'/>",
        "<joint axis='0 1 1' range='-10 20' stiffness='2' springref='1' armature='0.1'/>",
        "<joint type='ball'/>",
        "<freejoint/>",
        "<freejoint/>",
        "<inertial pos='1 2 3' mass='1' diaginertia='1 1 1'/>",
        "<inertial pos='0 0 0' mass='2' fullinertia='1 1 1 0.1 0 0.2'/>",
        "<geom size='0.1'/>",
        "<geom type='capsule' size='0.1' fromto='0 0 0 0 1 1'/>",
        "<geom type='box' size='1 2 3' mass='4' zaxis='1 1 1'/>",
        "<geom type='mesh' mesh='m'/>",
        "<site name='s' xyaxes='1 0 0 0 1 1'/>",
        "</worldbody><worldbody>",
        "</worldbody><default><default class='c'><joint type='slide'/></default></default><worldbody>",
        "</worldbody><compiler angle='radian' eulerseq='ZyX' settotalmass='3'/><worldbody>",
        "</worldbody><option gravity='1 2 3'/><worldbody>",
        "</worldbody><equality><connect body1='a' body2='world' anchor='1 1 1'/></equality><worldbody>",
        "</worldbody><equality><weld body1='a'/></equality><worldbody>",
        "</worldbody><equality><joint joint1='j' joint2='k'/></equality><worldbody>",
        "</worldbody><equality><joint joint1='k' joint2='j' polycoef='1 2 0'/></equality><worldbody>",
        "</worldbody><equality><connect site1='s' site2='s'/></equality><worldbody>",
        "</worldbody><tendon><fixed name='t'><joint joint='j' coef='2'/><joint joint='k' coef='1'/></fixed></tendon><worldbody>",
        "</worldbody><equality><tendon tendon1='t' polycoef='1'/></equality><worldbody>",
        "</worldbody><actuator><motor joint='j'/></actuator><worldbody>",
    ];

    #[test]
    fn elements_of_mjcf_in_any_order_are_read_or_refused() {
        let mut accepted = 0;
        cases::of_sizes(3000, 200, |bytes| {
            let mut text = String::from("<mujoco><worldbody>");
            let mut open = 0_usize;
            for _ in 0..bytes.int_in_range(1..=30)? {
                let piece = *bytes.choose(&MJCF_PIECES)?;
                let closes = piece.matches("</body>").count();
                // Most files are closed in order, so that more is read of them.
                if closes > open || piece.starts_with("</worldbody>") && open > 0 {
                    continue;
                }
                open = open + piece.matches("<body").count() - closes;
                text.push_str(piece);
            }
            text.push_str(&"</body>".repeat(open));
            text.push_str("</worldbody></mujoco>");
            accepted +=
                u32::from(robot::read_robot("r", text.as_bytes(), RobotBase::Fixed).is_ok());
            read_robot(text.as_bytes());
            let mut damaged = text.into_bytes();
            cases::damage(bytes, &mut damaged, 3, 60)?;
            read_robot(&damaged);
            Ok(())
        });
        assert!(
            accepted > 100,
            "{accepted} of 3000 were read, so little was tried"
        );
    }

    #[test]
    fn any_bytes_are_read_or_refused() {
        cases::of_sizes(300, 500, |bytes| {
            let length = bytes.len();
            read_robot(bytes.bytes(length)?);
            Ok(())
        });
    }

    #[test]
    fn elements_in_any_order_are_read_or_refused() {
        let mut accepted = 0;
        cases::of_sizes(3000, 200, |bytes| {
            let mut text = String::from("<robot name='r'>");
            for _ in 0..bytes.int_in_range(1..=30)? {
                text.push_str(bytes.choose(&PIECES)?);
            }
            text.push_str("</robot>");
            accepted +=
                u32::from(robot::read_robot("r", text.as_bytes(), RobotBase::Fixed).is_ok());
            read_robot(text.as_bytes());
            Ok(())
        });
        assert!(accepted > 0, "all were refused, so little was tried");
    }

    /// Sound robots are read; damage to their text finds more faults than
    /// random bytes.
    #[test]
    fn damaged_robots_are_read_or_refused() {
        let mut accepted = 0;
        cases::of_sizes(1500, 400, |bytes| {
            let mut text = sound(bytes)?;
            assert!(robot::read_robot("r", &text, RobotBase::Fixed).is_ok());
            read_robot(&text);
            cases::damage(bytes, &mut text, 3, 60)?;
            accepted += u32::from(robot::read_robot("r", &text, RobotBase::Fixed).is_ok());
            read_robot(&text);
            Ok(())
        });
        assert!(accepted > 0, "all damage was refused, so little was tried");
    }
}
