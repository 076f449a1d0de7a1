//! The attributes after an expression: cycle, addresses, times, places.
//!
//! Attributes may be in any order. They are collected here and attached to the
//! definition or assignment at the end of its line.

use super::builder::{ADDRESS, CYCLE, ModuleBuilder};
use super::parts::Span;
use super::problems::{also, error};
use crate::diagnostic::{clip, did_you_mean};
use crate::entity::Operand;
use crate::function::{Level, Timing};
use crate::history::History;
use crate::placement::{Address, BufferWord, Slot, Write};
use crate::source::{SourcePlace, SourceSet};

const TIMING_KEYS: [&str; 5] = ["asap", "alap", "asap_cycle", "alap_cycle", "mobility"];

impl ModuleBuilder<'_> {
    fn once(&mut self, first: Option<Span>, span: Span, what: &str) -> bool {
        if let Some(first) = first {
            self.conflict(span, format!("{what} is given twice"), first, "first here");
        }
        first.is_none()
    }

    /// An attribute that belongs to the level and those below.
    fn belongs_to(&mut self, level: Level, span: Span, what: &str) -> bool {
        let actual = self.open.function.level;
        let fits = actual >= level;
        if !fits && self.open.head.is_some() {
            self.advise(
                span,
                format!("a function of the level {actual} has no {what}"),
                &format!("this attribute belongs to the level {level}"),
            );
        }
        fits
    }

    /// `on add0 at 17` or `on host`.
    pub(super) fn on(&mut self, element: Span, cycle: Option<Span>, span: Span) {
        let first = self.attributes.slot.map(|(_, span)| span);
        if !self.belongs_to(Level::Scheduled, span, "schedule")
            || !self.once(first, span, "the processing element")
        {
            return;
        }
        let is_host = self.slice(element) == "host";
        // After an error the slot only has to be there.
        let slot = match cycle {
            None if is_host => None,
            Some(cycle) if is_host => {
                self.error(cycle, "a value of the host has no cycle");
                None
            }
            None => {
                self.advise(span, "the cycle is missing", "write 'on ELEMENT at CYCLE'");
                None
            }
            Some(cycle) => {
                let cycle = self.limited(cycle, "cycle", CYCLE);
                let element = self.element(element);
                element.map(|element| Slot { cycle, element })
            }
        };
        self.attributes.slot = Some((slot, span));
    }

    /// `read 12 40`.
    pub(super) fn read(&mut self, addresses: [Option<Span>; Operand::MAX_COUNT], span: Span) {
        let first = self.attributes.reads.map(|(_, span)| span);
        if self.belongs_to(Level::Placed, span, "addresses") && self.once(first, span, "'read'") {
            let reads = addresses.map(|address| {
                address.map(|address| Address::new(self.limited(address, "address", ADDRESS)))
            });
            self.attributes.reads = Some((reads, span));
        }
    }

    /// `buffer 2`.
    pub(super) fn buffer(&mut self, word: Span, span: Span) {
        let first = self.attributes.buffer.map(|(_, span)| span);
        if self.belongs_to(Level::Placed, span, "buffers") && self.once(first, span, "'buffer'") {
            let word = self.limited(word, "word of the buffer", ADDRESS);
            self.attributes.buffer = Some((BufferWord::new(word), span));
        }
    }

    /// `multi2[7] at 33` of `write`.
    pub(super) fn write(&mut self, element: Span, address: Span, cycle: Span, span: Span) {
        if !self.belongs_to(Level::Placed, span, "writes") {
            return;
        }
        let cycle = self.limited(cycle, "cycle", CYCLE);
        if let Some(word) = self.word(element, address) {
            self.writes.push(Write { word, cycle });
        }
        self.attributes.write.get_or_insert(span);
    }

    /// `in multi2[17]`.
    pub(super) fn home(&mut self, element: Span, address: Span, span: Span) {
        let first = self.attributes.home.map(|(_, span)| span);
        if !self.belongs_to(Level::Placed, span, "addresses")
            || !self.once(first, span, "the address")
        {
            return;
        }
        if let Some(word) = self.word(element, address) {
            self.attributes.home = Some((word, span));
        }
    }

    /// `as float(8,17)`; the word before it starts at `start`.
    pub(super) fn format(&mut self, name: Span, start: u32) {
        let span = Span::new(start, name.end);
        let first = self.attributes.format.map(|(_, span)| span);
        if !self.belongs_to(Level::Atomic, span, "formats of values")
            || !self.once(first, span, "the format")
        {
            return;
        }
        let text = self.slice(name);
        match text.parse() {
            Ok(format) => self.attributes.format = Some((format, span)),
            Err(problem) => {
                let message = format!("'{}' is not a number format", clip(text));
                self.advise(name, message, &problem.to_string());
            }
        }
    }

    /// `history 3`.
    pub(super) fn history(&mut self, number: Span, span: Span) {
        let first = self.attributes.history.map(|(_, span)| span);
        if self.once(first, span, "the history") {
            self.attributes.history = Some((self.history_of(number), span));
        }
    }

    /// The history of a number that was declared.
    pub(super) fn history_of(&mut self, number: Span) -> History {
        let index = self.integer(number);
        if let Some(&(history, _)) = self.open.histories.get(&index) {
            return history;
        }
        self.advise(
            number,
            format!("the history {index} is not declared"),
            &format!("a line like 'history {index} = \"balance\"' comes first"),
        );
        History::NONE
    }

    /// `asap 3` between braces.
    pub(super) fn timing_entry(&mut self, key: Span, number: Span) {
        let text = self.slice(key);
        let number = self.limited(number, "time", CYCLE);
        let Some(index) = TIMING_KEYS.iter().position(|known| *known == text) else {
            let message = format!("there is no time '{}'", clip(text));
            let help = match did_you_mean(text, TIMING_KEYS) {
                Some(nearest) => format!("did you mean '{nearest}'?"),
                None => format!("the times are {}", TIMING_KEYS.join(", ")),
            };
            return self.advise(key, message, &help);
        };
        if self.attributes.entries[index].replace(number).is_some() {
            self.error(key, format!("'{text}' is given twice"));
        }
    }

    /// `{asap 3 alap 5 asap_cycle 22 alap_cycle 31 mobility 9}`, its entries
    /// read before.
    pub(super) fn timing(&mut self, span: Span) {
        let first = self.attributes.timing.map(|(_, span)| span);
        if !self.belongs_to(Level::Atomic, span, "times") || !self.once(first, span, "the time") {
            return;
        }
        let entries = std::mem::take(&mut self.attributes.entries);
        let [
            Some(asap),
            Some(alap),
            Some(asap_cycle),
            Some(alap_cycle),
            mobility,
        ] = entries
        else {
            let mut missing = TIMING_KEYS.iter().zip(&entries);
            let (key, _) = missing
                .find(|(_, entry)| entry.is_none())
                .expect("one of the first four times is missing");
            self.error(span, format!("the time '{key}' is missing"));
            self.attributes.timing = Some((Timing::default(), span));
            return;
        };
        let timing = Timing {
            asap,
            alap,
            asap_cycle,
            alap_cycle,
        };
        let derived = timing.alap_cycle.checked_sub(timing.asap_cycle);
        match derived {
            None => self.error(span, "the latest cycle lies before the earliest"),
            Some(derived) if mobility.is_some_and(|mobility| mobility != derived) => self.advise(
                span,
                "the mobility is not the difference of the two cycles",
                &format!("it is {derived}, and can be left out"),
            ),
            Some(_) => {}
        }
        self.attributes.timing = Some((timing, span));
    }

    fn add_source(&mut self, set: SourceSet, span: Span) {
        let first = self.attributes.sources.map(|(_, span)| span);
        if let Some(first) = first {
            self.problems.push(
                error(span, "a statement has one place or one set of places")
                    .with_label(also(first, "the first one"))
                    .with_note("help: declare the set with 'places !0 = @1:2-3 @4:5-6' and refer to it as @!0"),
            );
        }
        self.attributes.sources = Some((set, span));
    }

    /// `@43:3-20` after a statement.
    pub(super) fn place(&mut self, span: Span) {
        if let Some(place) = self.read_place(span) {
            let set = self.module.tables.sources.single(place);
            self.add_source(set, span);
        }
    }

    /// A place of a set.
    pub(super) fn set_member(&mut self, span: Span) {
        if let Some(place) = self.read_place(span) {
            let set = self.module.tables.sources.single(place);
            self.members.push(set);
        }
    }

    /// `@!0`.
    pub(super) fn set_reference(&mut self, span: Span) {
        let number = self.integer(Span::new(span.start + 2, span.end));
        match self.open.sets.get(&number) {
            Some(&(set, _)) => self.add_source(set, span),
            None => self.advise(
                span,
                format!("the set of places !{number} is not declared"),
                &format!("a line like 'places !{number} = @1:2-3 @4:5-6' comes first"),
            ),
        }
    }

    fn read_place(&mut self, span: Span) -> Option<SourcePlace> {
        let Some(place) = scan_place(&self.text.as_bytes()[span.range()]) else {
            self.error(span, "a number of this place is too large");
            return None;
        };
        let starts = place.line.min(place.column).min(place.end_line) > 0;
        if !starts || (place.end_line, place.end_column) < (place.line, place.column) {
            self.advise(
                span,
                "this is no place",
                "lines and columns count from 1, and the end does not come before the start",
            );
            return None;
        }
        let files = self.module.tables.sources.files.len();
        if place.file as usize >= files {
            let message = format!("the source file {} is not declared", place.file);
            let help = format!("a line 'source {} \"NAME\"' comes first", place.file);
            self.advise(span, message, &help);
            return None;
        }
        Some(place)
    }
}

/// Reads `@file/line:column-line:column`, whose form the lexer has checked;
/// `None` when a number is too large.
fn scan_place(bytes: &[u8]) -> Option<SourcePlace> {
    let mut numbers = [0u32; 5];
    let mut count = 0;
    let (mut file, mut lines) = (false, 0);
    let mut number = 0u32;
    for &byte in bytes[1..].iter().chain(b"\n") {
        if byte.is_ascii_digit() {
            let digit = u32::from(byte - b'0');
            number = number.checked_mul(10)?.checked_add(digit)?;
            continue;
        }
        *numbers.get_mut(count)? = number;
        (count, number) = (count + 1, 0);
        file |= byte == b'/';
        lines += u32::from(byte == b':');
    }
    let (file, rest) = if file {
        (numbers[0], &numbers[1..])
    } else {
        (0, &numbers[..4])
    };
    let (line, column) = (rest[0], rest[1]);
    let (end_line, end_column) = match lines {
        2 => (rest[2], rest[3]),
        _ => (line, rest[2]),
    };
    Some(SourcePlace {
        file,
        line,
        column,
        end_line,
        end_column,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_scanned_in_all_four_forms() {
        let place = |file, line, column, end_line, end_column| SourcePlace {
            file,
            line,
            column,
            end_line,
            end_column,
        };
        assert_eq!(scan_place(b"@43:3-20"), Some(place(0, 43, 3, 43, 20)));
        assert_eq!(scan_place(b"@2/43:3-20"), Some(place(2, 43, 3, 43, 20)));
        assert_eq!(scan_place(b"@43:3-44:20"), Some(place(0, 43, 3, 44, 20)));
        assert_eq!(scan_place(b"@1/43:3-44:20"), Some(place(1, 43, 3, 44, 20)));
        assert_eq!(scan_place(b"@99999999999:3-20"), None);
    }
}
