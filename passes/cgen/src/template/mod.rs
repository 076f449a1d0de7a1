//! Targets as templates.
//!
//! A target is a folder of two files. `target.toml` holds the texts of
//! operations, elements and numbers ([`description`]); `template.jinja` is a
//! template of minijinja over the tree of the function ([`tree`]): arrays,
//! constants, and statements in program order. `docs/targets.md` describes
//! both.
//!
//! The objects of the tree are made when the template reads them, so that time
//! and memory grow with the number of operations only. An expression holds a
//! bounded number of operations ([`Inlining`](crate::emit::inlining::Inlining)).

mod description;
mod pattern;
mod tree;
mod view;

use description::TargetTexts;
use minijinja::syntax::SyntaxConfig;
use minijinja::{AutoEscape, Environment, Error, UndefinedBehavior};
use robovec_framework::pass::TargetFolder;
use robovec_ir::{Operation, View};
use std::ops::Range;
use tree::TargetTree;
use view::TreeObject;

/// Name of the description in the folder of a target.
pub const DESCRIPTION: &str = "target.toml";

/// Name of the template in the folder of a target.
pub const TEMPLATE: &str = "template.jinja";

/// Reason why a target cannot be used, or cannot be used for a function.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TargetError {
    /// The description is wrong.
    #[error("{folder}/{DESCRIPTION}:{line}: {message}")]
    Description {
        /// The folder.
        folder: String,
        /// The line, from 1.
        line: usize,
        /// The place in the description.
        span: Range<usize>,
        /// The fault.
        message: String,
    },
    /// The template is wrong.
    #[error("{folder}/{TEMPLATE}:{line}: {message}")]
    Template {
        /// The folder.
        folder: String,
        /// The line, from 1.
        line: usize,
        /// The fault.
        message: String,
    },
    /// The function has an operation without a text.
    #[error("{folder}/{DESCRIPTION} has no text for '{}', which '{function}' needs", operation.name())]
    Operation {
        /// The folder.
        folder: String,
        /// The operation.
        operation: Operation,
        /// The function.
        function: String,
    },
    /// The function has a number without a text.
    #[error("{folder}/{DESCRIPTION} has no text for the number {number}, which '{function}' needs")]
    Number {
        /// The folder.
        folder: String,
        /// The number: infinite, or not a number.
        number: String,
        /// The function.
        function: String,
    },
}

impl TargetError {
    /// Advice to the user.
    pub fn advice(&self) -> String {
        match self {
            TargetError::Operation { operation, .. } if operation.is_fused() => {
                "leave out the pass 'fma', or add the operation to [operations]".to_owned()
            }
            TargetError::Operation { .. } => "add it to [operations]".to_owned(),
            TargetError::Number { .. } => "add 'infinity' and 'nan' to [text]".to_owned(),
            TargetError::Description { .. } | TargetError::Template { .. } => {
                "docs/targets.md describes the keys of a target and the names in its template"
                    .to_owned()
            }
        }
    }
}

/// A target, read.
#[derive(Clone, Debug)]
pub struct CodeTarget {
    folder: TargetFolder,
    texts: TargetTexts,
}

macro_rules! built_in {
    ($($name:literal),+) => {
        /// The targets that ship: name, description, template.
        const BUILT_IN: &[[&str; 3]] = &[$([
            $name,
            include_str!(concat!("../../targets/", $name, "/target.toml")),
            include_str!(concat!("../../targets/", $name, "/template.jinja")),
        ]),+];
    };
}

built_in!("jax", "llvm", "mlir", "numpy", "rust");

impl CodeTarget {
    /// A target that ships.
    ///
    /// # Panics
    ///
    /// Panics if none has this name.
    pub fn built_in(name: &str) -> CodeTarget {
        let found = BUILT_IN.iter().find(|known| known[0] == name);
        let [name, description, template] = found.expect("a target that ships").map(str::to_owned);
        let folder = TargetFolder {
            name,
            description,
            template,
        };
        CodeTarget::parse(&folder).expect("a valid target ships")
    }

    /// Reads a target.
    ///
    /// # Errors
    ///
    /// Reports the first fault of the description or of the template's grammar.
    pub fn parse(folder: &TargetFolder) -> Result<CodeTarget, TargetError> {
        let target = CodeTarget {
            texts: TargetTexts::parse(folder)?,
            folder: folder.clone(),
        };
        target.environment()?;
        Ok(target)
    }

    /// The file of a function of any level: its name and its text.
    ///
    /// # Errors
    ///
    /// Reports an operation or number that the target has no text for, or where
    /// the template fails.
    pub fn file(&self, view: View<'_>) -> Result<(String, String), TargetError> {
        let tree = TargetTree::new(view, &self.texts);
        let function = || view.function.name.clone();
        if let Some(operation) = tree.foreign_operation() {
            return Err(TargetError::Operation {
                folder: self.folder.name.clone(),
                operation,
                function: function(),
            });
        }
        if let Some(number) = tree.foreign_number() {
            return Err(TargetError::Number {
                folder: self.folder.name.clone(),
                number: number.to_string(),
                function: function(),
            });
        }
        let name = self.texts.file.fill(|_| tree.title.clone());
        let environment = self.environment()?;
        let template = environment.get_template(TEMPLATE);
        let text = template.and_then(|template| template.render(TreeObject::root(tree)));
        Ok((name, text.map_err(|error| self.fault(&error))?))
    }

    /// The template, ready to be rendered.
    fn environment(&self) -> Result<Environment<'_>, TargetError> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        environment.set_auto_escape_callback(|_| AutoEscape::None);
        let syntax = SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .keep_trailing_newline(true)
            .build();
        environment.set_syntax(syntax.expect("the usual delimiters"));
        let added = environment.add_template(TEMPLATE, &self.folder.template);
        added.map_err(|error| self.fault(&error))?;
        Ok(environment)
    }

    fn fault(&self, error: &Error) -> TargetError {
        let line = error.line().unwrap_or(1);
        let text = self.folder.template.lines().nth(line.saturating_sub(1));
        let text = text.unwrap_or_default().trim();
        let detail = error.detail().map_or(String::new(), |it| format!(": {it}"));
        TargetError::Template {
            folder: self.folder.name.clone(),
            line,
            message: format!("{}{detail}, in '{text}'", error.kind()),
        }
    }
}

/// The line of a place in a text, from 1.
fn line_of(text: &str, place: usize) -> usize {
    1 + text[..place.min(text.len())].matches('\n').count()
}
