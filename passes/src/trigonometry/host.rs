//! Sines and cosines left to the host, with the method by which it computes
//! them.

use super::Trigonometry;
use super::options::CircularMethod;
use robovec_framework::pass::{Context, PassError};
use robovec_ir::Function;
use robovec_num::trigonometry::host::{Implementation, KEY, TrigonometricUnit};

/// The order of the host's polynomials where none is given: on an eighth of a
/// turn they are then better than binary32.
const ORDER: u32 = 9;

impl Trigonometry {
    /// Records in the function the method for its sines and cosines, and
    /// reports the proved error.
    pub(super) fn record(
        &self,
        function: &mut Function,
        context: &mut Context<'_>,
    ) -> Result<(), PassError> {
        let nodes = function.nodes().iter();
        let count = nodes
            .filter(|node| node.operation.is_trigonometric())
            .count();
        let implementation = self.implementation();
        let unit = TrigonometricUnit::new(implementation).map_err(|error| {
            PassError::new(format!("there is no {implementation}")).help(error.to_string())
        })?;
        let statistic = ("sines and cosines of the host", count as u64);
        context.statistics.push(statistic);
        function.metadata.retain(|(key, _)| key != KEY);
        function
            .metadata
            .push((KEY.to_owned(), implementation.to_string()));
        let cost = unit.cost();
        context.remark(format!(
            "{count} sines and cosines before the run by {implementation}: an error of at most \
             {:.2e} for angles below 2^50, about {} cycles each, {} bits of tables",
            unit.proved_error(),
            cost.latency,
            cost.table_bits
        ));
        Ok(())
    }

    fn implementation(&self) -> Implementation {
        let bits = self.bits;
        match self.method {
            CircularMethod::Cordic => Implementation::Cordic {
                iterations: self.iterations,
                bits,
            },
            CircularMethod::Table => Implementation::Table {
                entries: self.entries,
                degree: self.degree,
                bits,
            },
            _ => Implementation::Polynomial {
                order: if self.order == 0 { ORDER } else { self.order },
                bits,
            },
        }
    }
}
