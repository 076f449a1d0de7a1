//! Equations of multibody systems from models, and models in motion.

pub mod fmu;
pub mod generate;
pub mod kinematics;
pub mod motion;
pub mod stale;
pub mod whole_step;
