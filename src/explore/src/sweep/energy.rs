//! Energy beside time, from figures of power that the user brings.
//!
//! There are no known published power figures for such operators on these
//! devices, so none is built in. The user reads the power of the idle device
//! and of the full one from its vendor's power estimator or a meter; the power
//! of a design is interpolated between the two by its share of the device.
//! Without figures only the break-even is reported: a design takes less energy
//! than a processor if the ratio of powers is below the inverse ratio of times.

use super::FunctionSweep;
use robovec_num::limits::NumberLimit;
use serde::Serialize;

/// Limit of a power flag.
pub const WATTS: NumberLimit = NumberLimit::real(
    0.0,
    10_000.0,
    "power in watts of a device or a core; energy is power multiplied by time",
);

/// Power of the device and of a core.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct PowerFigures {
    /// The device with nothing running, W.
    pub idle_watts: f64,
    /// The device with all of its cells in use, W.
    pub full_watts: f64,
    /// One busy core of the processor, W.
    pub core_watts: Option<f64>,
}

impl FunctionSweep {
    /// Adds the energy of an evaluation to points and the processor.
    pub(super) fn add_energy(&mut self, power: PowerFigures) {
        for point in &mut self.points {
            let used = (power.full_watts - power.idle_watts) * point.share.min(1.0);
            // Watts times microseconds are microjoules.
            point.energy_uj = Some((power.idle_watts + used) * point.us_per_evaluation);
        }
        let core = power.core_watts.zip(self.cpu_us);
        self.cpu_energy_uj = core.map(|(watts, time)| watts * time);
        self.power = Some(power);
    }

    /// The design of the smallest energy beside the processor, if known.
    pub(super) fn energy(&self) -> Vec<String> {
        let fitting = || self.points.iter().filter(|point| point.share <= 1.0);
        let mut texts = Vec::new();
        let least = fitting().filter_map(|point| point.energy_uj.map(|energy| (energy, point)));
        if let Some((energy, point)) = least.min_by(|a, b| a.0.total_cmp(&b.0)) {
            let mut text = format!(
                "the design of {}+{} elements and {} at once that takes {:.1} % of the device \
                 needs the least energy, {energy:.3} uJ per evaluation",
                point.design.adders,
                point.design.multipliers,
                point.design.instances,
                100.0 * point.share
            );
            if let Some(core) = self.cpu_energy_uj {
                text += &format!(", one core of this computer {core:.3} uJ");
            }
            texts.push(text);
        }
        let fastest = fitting().map(|point| point.us_per_evaluation);
        if let (Some(cpu), Some(own)) = (self.cpu_us, fastest.min_by(f64::total_cmp)) {
            texts.push(format!(
                "the fastest design that fits needs less energy than a core if the device draws \
                 less than {:.3} times the core's power",
                cpu / own
            ));
        }
        texts
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::small_sweep;
    use super::PowerFigures;

    #[test]
    fn energy_is_power_times_time() {
        let (_, mut sweep) = small_sweep(&[1]);
        sweep.cpu_us = Some(2.0);
        sweep.add_energy(PowerFigures {
            idle_watts: 0.5,
            full_watts: 2.5,
            core_watts: Some(10.0),
        });
        assert_eq!(sweep.cpu_energy_uj, Some(20.0));
        for point in &sweep.points {
            let watts = 0.5 + 2.0 * point.share;
            let energy = point.energy_uj.expect("it was added");
            assert!((energy - watts * point.us_per_evaluation).abs() < 1e-12);
        }
        assert!(sweep.energy()[0].contains("20.000 uJ"));
    }

    #[test]
    fn without_power_the_ratio_is_printed() {
        let (_, mut sweep) = small_sweep(&[1]);
        assert!(sweep.energy().is_empty());
        sweep.cpu_us = Some(2.0);
        assert!(sweep.energy()[0].contains("times the core's power"));
    }
}
