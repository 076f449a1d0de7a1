//! The numbers in the kernel.

use crate::c::Real;

/// The numbers of a kernel. A test derives the polynomials again (Remez,
/// [`robovec_num::trigonometry::Polynomial::minimax_behind`]) and the parts
/// from the digits of pi.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct KernelConstants {
    /// Largest angle in radians that is not left to the library: the number of
    /// quarter turns for which the products of the first parts are exact.
    pub(crate) limit: f64,
    /// Quarter turns per radian.
    pub(crate) turns: f64,
    /// 1.5 times the power of two from which on the last bit counts ones:
    /// added, it rounds to an integer and leaves it in the last bits.
    pub(crate) rounder: f64,
    /// A quarter turn in parts. All but the last leave room for the digits of
    /// the largest number of quarter turns.
    pub(crate) quarter: &'static [f64],
    /// `sin x = x + x^3 (s[0] + s[1] x^2 + …)` up to an eighth of a turn.
    pub(crate) sine: &'static [f64],
    /// `cos x = 1 - x^2/2 + x^4 (c[0] + c[1] x^2 + …)`.
    pub(crate) cosine: &'static [f64],
}

impl KernelConstants {
    /// The numbers for a type.
    pub(crate) fn of(real: Real) -> &'static KernelConstants {
        match real {
            Real::Double => &DOUBLE,
            Real::Float => &FLOAT,
        }
    }
}

/// Parts of 33, 33 and 53 bits: up to 2^20 quarter turns. The sine is within
/// 2^-56.7 of itself, the cosine within 2^-63.
static DOUBLE: KernelConstants = KernelConstants {
    limit: 1_048_576.0,
    turns: std::f64::consts::FRAC_2_PI,
    rounder: 6_755_399_441_055_744.0,
    quarter: &[
        1.5707963267341256,
        6.077100506303966e-11,
        2.0222662487959506e-21,
    ],
    sine: &[
        -0.166666666666666,
        0.008333333333316218,
        -0.0001984126982574252,
        2.755731247949508e-6,
        -2.5050589771977303e-8,
        1.588795397105756e-10,
    ],
    cosine: &[
        0.0416666666666666,
        -0.0013888888888874472,
        2.480158728966933e-5,
        -2.7557314400352683e-7,
        2.0875729198203035e-9,
        -1.1359930659200633e-11,
    ],
};

/// Parts of three times 12 and 24 bits: up to 2^12 quarter turns. The sine is
/// within 2^-27.3 of itself, the cosine within 2^-32.7.
static FLOAT: KernelConstants = KernelConstants {
    limit: 4096.0,
    turns: std::f32::consts::FRAC_2_PI as f64,
    rounder: 12_582_912.0,
    quarter: &[
        1.5703125,
        0.0004837512969970703,
        7.549533620476723e-8,
        2.5633440682570896e-12,
    ],
    sine: &[
        -0.16666650772094727,
        0.008331983350217342,
        -0.0001949612924363464,
    ],
    cosine: &[
        0.04166664555668831,
        -0.00138873013202101,
        2.4430695702903904e-5,
    ],
};
