//! The content of a machine as far as a placed program depends on it, as a
//! hash.
//!
//! A name is no identity: a copy of a machine file keeps it while stages,
//! memories and ports change, and a program placed for the one is wrong on the
//! other. So a schedule has the hash of its machine
//! ([`Schedule::machine_hash`]), and so do the manifests of images.

use super::Machine;
use crate::placement::Schedule;
use robovec_num::fnv::Fnv;

impl Machine {
    /// 64-bit FNV-1a of the properties on which a program depends: the compact
    /// JSON of `[number, elements, memory, buffer, interconnect]` of the
    /// machine file with every element's `count` set to 1, since placement may
    /// use other counts and records them. Name, description, clock, device,
    /// instruction memories and resources change no placement.
    pub fn content_hash(&self) -> Fnv {
        let mut elements = self.elements.clone();
        for element in &mut elements {
            element.count = 1;
        }
        let essence = (
            self.number,
            elements,
            self.memory,
            self.buffer,
            self.interconnect,
        );
        let text = serde_json::to_vec(&essence).expect("a machine is numbers, texts and lists");
        Fnv::of(&text)
    }
}

/// A schedule and a machine that do not belong together.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum MachineMismatch {
    /// The schedule names a machine of another content.
    #[error("the schedule is for the machine '{own}', not '{other}'")]
    Name {
        /// Of the schedule.
        own: String,
        /// Of the machine.
        other: String,
    },
    /// The machine has another content than that of the schedule.
    #[error(
        "the schedule is for a machine '{own}' with the hash {own_hash}, and '{other}' has the \
         hash {other_hash}"
    )]
    Content {
        /// Name in the schedule.
        own: String,
        /// Hash in the schedule.
        own_hash: Fnv,
        /// Name of the machine.
        other: String,
        /// Hash of the machine.
        other_hash: Fnv,
    },
}

impl MachineMismatch {
    /// The remedies, for the user.
    pub fn advice(&self) -> String {
        match self {
            MachineMismatch::Name { own, .. } => format!(
                "choose that machine ('--machine {own}', or its file), or place the program \
                 again for this one"
            ),
            MachineMismatch::Content { own, other, .. } if own == other => format!(
                "the file of '{own}' was changed, or there are several of this name: give the one \
                 the program was placed for, or place the program again"
            ),
            MachineMismatch::Content { .. } => {
                "give the file of the machine the program was placed for, or place the program \
                 again for this one"
                    .to_owned()
            }
        }
    }
}

impl Schedule {
    /// Tests whether the schedule was made for a machine of this content; by
    /// the machine's name where the schedule has no hash.
    ///
    /// # Errors
    ///
    /// The difference, when it was made for another.
    pub fn check_machine(&self, machine: &Machine) -> Result<(), MachineMismatch> {
        let (own, other) = (self.machine.clone(), machine.name.clone());
        let Some(own_hash) = self.machine_hash else {
            return if own == other {
                Ok(())
            } else {
                Err(MachineMismatch::Name { own, other })
            };
        };
        let other_hash = machine.content_hash();
        if own_hash == other_hash {
            return Ok(());
        }
        Err(MachineMismatch::Content {
            own,
            own_hash,
            other,
            other_hash,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::format::Format;

    fn thesis() -> Machine {
        Machine::built_in("thesis").expect("it ships")
    }

    fn schedule(machine_hash: Option<Fnv>) -> Schedule {
        Schedule {
            machine: "thesis".to_owned(),
            machine_hash,
            kinds: Vec::new(),
            slots: Vec::new(),
            cycles: 0,
            lower_bound: 0,
        }
    }

    #[test]
    fn what_a_program_depends_on_is_part_of_the_content() {
        let changes: [fn(&mut Machine); 7] = [
            |machine| machine.elements[0].stages += 1,
            |machine| machine.elements[0].operations.push("sqrt".to_owned()),
            |machine| machine.elements[0].kind = "other".to_owned(),
            |machine| machine.memory.words = Some(77),
            |machine| machine.memory.writes = Some(7),
            |machine| machine.buffer = None,
            |machine| machine.number = Format::BINARY64,
        ];
        for change in changes {
            let mut machine = thesis();
            change(&mut machine);
            assert_ne!(machine.content_hash(), thesis().content_hash());
            let error = schedule(Some(thesis().content_hash())).check_machine(&machine);
            assert!(matches!(error, Err(MachineMismatch::Content { .. })));
        }
    }

    #[test]
    fn names_counts_and_the_clock_are_not() {
        let mut machine = thesis();
        machine.name = "mine".to_owned();
        machine.description.clear();
        machine.clock_mhz = Some(1.0);
        machine.device = crate::machine::DeviceFamily::Ecp5;
        machine.resources = None;
        machine.elements[0].count += 3;
        assert_eq!(machine.content_hash(), thesis().content_hash());
        let hash = Some(thesis().content_hash());
        assert_eq!(schedule(hash).check_machine(&machine), Ok(()));
        let error = schedule(None).check_machine(&machine);
        assert!(matches!(error, Err(MachineMismatch::Name { .. })));
        assert_eq!(schedule(None).check_machine(&thesis()), Ok(()));
    }

    #[test]
    fn the_hash_of_a_shipped_machine_stays() {
        assert_eq!(thesis().content_hash().text(), "75dc667cc87998a4");
    }
}
