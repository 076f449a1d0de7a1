//! Other units of length, mass and time: powers of two of the SI units.
//!
//! Multiplying by a power of two is exact as long as nothing leaves the range
//! of the format. A program with all its numbers in such units therefore makes
//! the same rounding errors, bit for bit, and only the range of its numbers
//! moves: numbers that were too small or too large for a format may fit. The
//! host scales parameters once and states before each run; the program stays.

use robovec_model::Model;
use robovec_num::power::times_power_of_two;

/// Units, as exponents of powers of two by which numbers in SI units are
/// multiplied: length 10 stores a metre as 1024.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Units {
    /// Of lengths.
    pub length: i32,
    /// Of masses.
    pub mass: i32,
    /// Of times.
    pub time: i32,
}

/// The physical dimension of a quantity: powers of length, mass and time.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Dimension {
    /// Power of the length.
    pub length: i32,
    /// Power of the mass.
    pub mass: i32,
    /// Power of the time.
    pub time: i32,
}

impl Dimension {
    const fn new(length: i32, mass: i32, time: i32) -> Dimension {
        Dimension { length, mass, time }
    }

    /// The dimension of an element of one of Robotran's arrays, if it is one.
    pub fn of(model: &Model, array: &str, indices: &[u32]) -> Dimension {
        let turns = |index: usize| {
            let joint = indices.get(index).and_then(|i| i.checked_sub(1));
            let joint = joint.and_then(|joint| model.joints.get(joint as usize));
            joint.is_none_or(|joint| joint.kind.is_revolute())
        };
        // Positions of prismatic joints are lengths, their forces no torques.
        let position = |index: usize| i32::from(!turns(index));
        let lever = |index: usize| i32::from(turns(index));
        match array {
            "q" => Dimension::new(position(0), 0, 0),
            "qd" => Dimension::new(position(0), 0, -1),
            "qdd" => Dimension::new(position(0), 0, -2),
            "l" | "dpt" | "lrod" => Dimension::new(1, 0, 0),
            "m" => Dimension::new(0, 1, 0),
            "In" => Dimension::new(2, 1, 0),
            "g" => Dimension::new(1, 0, -2),
            "tsim" => Dimension::new(0, 0, 1),
            "frc" => Dimension::new(1, 1, -2),
            "trq" => Dimension::new(2, 1, -2),
            "Qq" | "c" => Dimension::new(1 + lever(0), 1, -2),
            "M" => Dimension::new(lever(0) + lever(1), 1, 0),
            _ => Dimension::default(),
        }
    }
}

impl Units {
    /// Metre, kilogram, second.
    pub const SI: Units = Units {
        length: 0,
        mass: 0,
        time: 0,
    };

    /// Units in which the model's longest length, heaviest body and gravity
    /// (or, without it, nothing) are of the order of one.
    pub fn of(model: &Model) -> Units {
        let centers = model.bodies.iter().flat_map(|body| &body.center);
        let points = model.points.iter().flat_map(|point| &point.coordinates);
        let length = -exponent(centers.chain(points));
        let mass = -exponent(model.bodies.iter().map(|body| &body.mass));
        // With the units of length chosen, gravity is of the order of one when
        // twice the exponent of the time is its own.
        let gravity = match exponent(&model.gravity) {
            0 => 0,
            exponent => exponent + length,
        };
        Units {
            length,
            mass,
            time: gravity.div_euclid(2),
        }
    }

    fn shift(self, dimension: Dimension) -> i32 {
        self.length * dimension.length + self.mass * dimension.mass + self.time * dimension.time
    }

    /// A number in SI units, converted to its stored unit.
    pub fn stored(self, number: f64, dimension: Dimension) -> f64 {
        times_power_of_two(number, self.shift(dimension))
    }

    /// Value of a stored number in SI units.
    pub fn meant(self, number: f64, dimension: Dimension) -> f64 {
        times_power_of_two(number, -self.shift(dimension))
    }
}

/// The exponent of the largest of some numbers; 0 when all are zero.
fn exponent<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> i32 {
    let largest = numbers
        .into_iter()
        .fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return 0;
    }
    // The bits say it exactly; a logarithm might not.
    ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family::built_in;

    #[test]
    fn units_are_exact_and_bring_the_model_to_one() {
        let mut model = built_in("double-pendulum").expect("a family");
        for point in &mut model.points {
            point.coordinates = point.coordinates.map(|x| x * 1e-9);
        }
        for body in &mut model.bodies {
            body.center = body.center.map(|x| x * 1e-9);
            body.mass *= 1e-27;
        }
        let units = Units::of(&model);
        let length = Dimension::new(1, 0, 0);
        let stored = units.stored(1e-9, length);
        assert!((0.5..4.0).contains(&stored), "{units:?}");
        assert_eq!(units.meant(stored, length), 1e-9);
        let gravity = units.stored(9.81, Dimension::new(1, 0, -2));
        assert!((0.25..4.0).contains(&gravity), "{gravity}");
        assert!((0.5..4.0).contains(&units.stored(2e-27, Dimension::new(0, 1, 0))));
    }
}
