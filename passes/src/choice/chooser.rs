//! One of two ways to choose forms.

use super::curve_map::CurveMapper;
use super::map::{Mapper, Mapping};
use robovec_framework::option_words;

option_words! {
    /// Way in which forms are chosen.
    #[derive(Default)]
    pub enum ChoiceMethod {
        /// By curves of the cost of a value over its required time: the best
        /// known method.
        #[default]
        Curves = "curves",
        /// By estimated shares of operations: several times faster.
        Flow = "flow",
    }
}

/// The largest network that is chosen from by curves, in classes: the others
/// would take minutes.
const LARGEST_BY_CURVES: usize = 200_000;

/// Chooses forms of a network, for one time after the other.
pub(crate) enum FormChooser<'a, 'n> {
    Curves {
        mapper: CurveMapper<'a, 'n>,
        rounds: u32,
    },
    Flow {
        mapper: &'a Mapper<'n>,
        earliest: Mapping,
        /// The mapping that was kept last.
        model: Mapping,
        rounds: u32,
    },
}

impl<'a, 'n> FormChooser<'a, 'n> {
    /// Large networks are always chosen from by flow.
    pub(crate) fn new(
        mapper: &'a Mapper<'n>,
        method: ChoiceMethod,
        rounds: u32,
    ) -> FormChooser<'a, 'n> {
        match method {
            ChoiceMethod::Curves if mapper.forms.len() <= LARGEST_BY_CURVES => {
                let mapper = CurveMapper::new(mapper);
                FormChooser::Curves { mapper, rounds }
            }
            _ => FormChooser::Flow {
                mapper,
                earliest: mapper.earliest(),
                model: mapper.cheapest(rounds),
                rounds,
            },
        }
    }

    /// The shortest possible path.
    pub(crate) fn shortest(&self) -> u32 {
        match self {
            FormChooser::Curves { mapper, .. } => mapper.shortest(),
            FormChooser::Flow {
                mapper, earliest, ..
            } => mapper.path(earliest),
        }
    }

    /// Minimum number of steps in which a search shortens the path, and the
    /// part of the path below which a step is not worth its time.
    pub(crate) fn steps(&self) -> (u32, u64) {
        match self {
            FormChooser::Curves { .. } => (3, 150),
            FormChooser::Flow { .. } => (10, 400),
        }
    }

    /// A mapping with few operations and no output later than `latest`, the only
    /// one that is requested.
    pub(crate) fn map_once(self, latest: u32) -> Mapping {
        match self {
            FormChooser::Curves { mut mapper, rounds } => mapper.map(latest, rounds, None),
            FormChooser::Flow {
                mapper,
                mut earliest,
                model,
                rounds,
            } => {
                mapper.recover(&mut earliest, latest, rounds, Some(&model));
                earliest
            }
        }
    }

    /// A mapping with few operations and no output later than `latest`. Fewer
    /// than `enough` operations are not worth time.
    pub(crate) fn map(&mut self, latest: u32, enough: u64) -> Mapping {
        match self {
            FormChooser::Curves { mapper, rounds } => mapper.map(latest, *rounds, Some(enough)),
            FormChooser::Flow {
                mapper,
                earliest,
                model,
                rounds,
            } => {
                let mut mapping = earliest.clone();
                mapper.recover(&mut mapping, latest, *rounds, Some(model));
                mapping
            }
        }
    }

    /// A mapping as [`FormChooser::map`] makes it, with more time, where that
    /// took less than it could.
    pub(crate) fn map_again(&mut self, latest: u32) -> Option<Mapping> {
        match self {
            FormChooser::Curves { mapper, rounds } => Some(mapper.map(latest, *rounds, None)),
            FormChooser::Flow { .. } => None,
        }
    }

    /// Lets the next mapping be modelled on one.
    pub(crate) fn keep(&mut self, mapping: Mapping) {
        if let FormChooser::Flow { model, .. } = self {
            *model = mapping;
        }
    }

    /// Forgets the mappings made since one was kept.
    pub(crate) fn go_back(&mut self) {
        if let FormChooser::Curves { mapper, .. } = self {
            mapper.go_back();
        }
    }
}
