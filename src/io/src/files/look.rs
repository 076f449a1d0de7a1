//! The kind of a file, by its first bytes, for messages about wrong files.
//!
//! **Invariant.** A file that the reader of its kind would accept is recognised
//! as that kind or as no particular kind.

robovec_num::named! {
    /// A kind of file.
    #[derive(Clone, Copy, PartialEq, Eq, Debug)]
    pub enum FileKind {
        /// Equations, in any language.
        Equations = "a file of equations",
        /// A model.
        Model = "a model (.mbs, .urdf, .xml)",
        /// A pipeline.
        Pipeline = "a pipeline",
        /// A machine.
        Machine = "a machine",
        /// A scene.
        Scene = "a scene",
        /// Laws of forces.
        Laws = "a file of laws",
        /// A plan of a study.
        Plan = "a plan of a study",
        /// Rules.
        Rules = "a file of rules",
        /// Rules of another tool.
        ForeignRules = "a file of rules of another tool",
        /// States.
        States = "a file of states",
        /// A memory image or its manifest.
        Image = "a memory image",
        /// A description of hardware.
        Hardware = "a description of hardware (machine.json)",
        /// The description of a target of code generation.
        Target = "the description of a target (target.toml)",
        /// The template of a target: text of any language.
        Template = "a template (template.jinja)",
    }
}

impl FileKind {
    pub(super) fn is_toml(self) -> bool {
        matches!(
            self,
            FileKind::Machine
                | FileKind::Scene
                | FileKind::Laws
                | FileKind::Plan
                | FileKind::Target
        )
    }

    /// The commands that take such a file.
    pub(super) fn takers(self) -> &'static str {
        match self {
            FileKind::Equations => "'robovec-opt', 'robovec optimise' and 'robovec eval' take it",
            FileKind::Model => {
                "'robovec gen' and 'robovec sim' take it, and others when its name ends in .mbs, \
                 .urdf or .xml"
            }
            FileKind::Pipeline => "'robovec-opt --passes @FILE' takes it",
            FileKind::Machine => "'robovec-opt --machine FILE' takes it",
            FileKind::Scene => "'robovec fit' and the option '--scene' take it",
            FileKind::Laws => "'robovec sim MODEL --laws FILE' takes it",
            FileKind::Plan => "'robovec explore --plan FILE' takes it",
            FileKind::Rules => "'robovec rules check' and the option '--rules' take it",
            FileKind::ForeignRules => "'robovec rules import' takes it",
            FileKind::States => "'robovec eval EQUATIONS --states FILE' takes it",
            FileKind::Image => "'robovec rtl simulate' takes its folder",
            FileKind::Hardware => "'robovec rtl PROGRAM --fits FILE' takes it",
            FileKind::Target | FileKind::Template => "'robovec-opt --target' takes its folder",
        }
    }
}

/// Number of bytes at the beginning of a file that show its kind.
const HEAD: usize = 4096;

/// First bytes of files that hold no text.
const BINARY: [(&[u8], &str); 11] = [
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    (b"%PDF-", "a PDF document"),
    (b"\x7fELF", "a compiled program"),
    (b"!<arch>", "a library of compiled code"),
    (
        b"PK\x03\x04",
        "a ZIP archive (as .docx and .xlsx files are)",
    ),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\xfd7zXZ", "an xz archive"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive"),
    (b"\x93NUMPY", "an array of NumPy"),
];

/// Tables and keys that only files of one kind have in TOML.
const TABLES: [(FileKind, &[&str]); 5] = [
    (FileKind::Target, &["[operations]"]),
    (FileKind::Machine, &["[[element]]", "clock_mhz ="]),
    (FileKind::Plan, &["[[sweep]]", "[[pipeline]]"]),
    (
        FileKind::Laws,
        &[
            "[[joint]]",
            "[[link]]",
            "[[force]]",
            "[[contact]]",
            "[[driven]]",
            "[[event]]",
        ],
    ),
    (
        FileKind::Scene,
        &[
            "[[output]]",
            "[range]",
            "[bind]",
            "model = \"",
            "equations = \"",
        ],
    ),
];

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum FileLook {
    /// Empty, or white space.
    Empty,
    /// A kind that at least one command takes.
    Known(FileKind),
    /// TOML of no kind in particular.
    Toml,
    /// JSON, of which some is hardware.
    Json,
    /// XML without the first element of a model.
    Xml,
    /// A kind of file that no command takes.
    Foreign(&'static str),
    /// No known kind.
    Unknown,
}

pub(super) fn look(name: &str, bytes: &[u8]) -> FileLook {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return FileLook::Empty;
    }
    if let Some((_, what)) = BINARY.iter().find(|(first, _)| bytes.starts_with(first)) {
        return FileLook::Foreign(what);
    }
    if name.ends_with(".md") {
        return FileLook::Foreign("a text for people");
    }
    let bytes = &bytes[..bytes.len().min(HEAD)];
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    if bytes.contains(&0) && !is_utf16 {
        return FileLook::Foreign("data that is not text");
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let found = markup(text)
        .or_else(|| list(text))
        .or_else(|| toml(name, text));
    found
        .or_else(|| lines(text))
        .or_else(|| {
            robovec_robotran::is_equations(name, text)
                .then_some(FileLook::Known(FileKind::Equations))
        })
        .unwrap_or(FileLook::Unknown)
}

fn markup(text: &str) -> Option<FileLook> {
    let text = text.trim_start();
    if !text.starts_with('<') {
        return None;
    }
    let models = ["<mbsDescR7", "<robot", "<mujoco"];
    let lower = text.to_ascii_lowercase();
    Some(if models.iter().any(|first| text.contains(first)) {
        FileLook::Known(FileKind::Model)
    } else if lower.starts_with("<!doctype html") || lower.contains("<html") {
        FileLook::Foreign("a page of HTML")
    } else if lower.contains("<svg") {
        FileLook::Foreign("an SVG image")
    } else {
        FileLook::Xml
    })
}

/// Parenthesised text.
fn list(text: &str) -> Option<FileLook> {
    let mut lines = text.lines().map(str::trim_start);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with([';', '#']))?;
    let heads = [
        "(FPCore",
        "(rewrite",
        "(birewrite",
        "(datatype",
        "(define-rule",
    ];
    Some(
        match heads.iter().position(|head| first.starts_with(head))? {
            0 => FileLook::Known(FileKind::Equations),
            _ => FileLook::Known(FileKind::ForeignRules),
        },
    )
}

fn toml(name: &str, text: &str) -> Option<FileLook> {
    let is_named = name.ends_with(".toml");
    let mut lines = text.lines().map(str::trim);
    if !is_named && !lines.clone().any(|line| line.starts_with("[[")) {
        return None;
    }
    let has = |mark: &&str| lines.clone().any(|line| line.starts_with(mark));
    let kind = TABLES.iter().find(|(_, marks)| marks.iter().any(has));
    let is_toml = |line: &str| line.starts_with('[') || line.contains(" = ");
    match kind {
        Some((kind, _)) => Some(FileLook::Known(*kind)),
        None if lines.any(is_toml) && is_named => Some(FileLook::Toml),
        None => None,
    }
}

/// Kind of file that a line shows.
fn lines(text: &str) -> Option<FileLook> {
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let mut lines = text.lines().map(str::trim).filter(is_code);
    let first = lines.next()?;
    if first.starts_with("// robovec ") || text.starts_with("// RUN:") {
        return Some(FileLook::Known(FileKind::Equations));
    }
    if first == "state" {
        return Some(FileLook::Known(FileKind::States));
    }
    if first.starts_with("rule ") && first.contains(':') {
        return Some(FileLook::Known(FileKind::Rules));
    }
    (first.starts_with('{') && (first.contains('"') || first == "{")).then_some(FileLook::Json)
}
