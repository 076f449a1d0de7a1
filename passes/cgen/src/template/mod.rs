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
use robovec_ir::View;
use std::ops::Range;
use tree::TargetTree;

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
    /// The function has an operation or a number without a text.
    #[error("{folder}/{DESCRIPTION} has no text for {what}, which '{function}' needs")]
    Missing {
        /// The folder.
        folder: String,
        /// The operation or number.
        what: String,
        /// The function.
        function: String,
    },
}

impl TargetError {
    /// Advice to the user.
    pub fn advice(&self) -> &'static str {
        match self {
            TargetError::Missing { .. } => {
                "add it to the description; without the pass 'fma' no operation is fused"
            }
            TargetError::Description { .. } | TargetError::Template { .. } => {
                "docs/targets.md describes the keys of a target and the names in its template"
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
        if let Some(what) = tree.missing() {
            return Err(TargetError::Missing {
                folder: self.folder.name.clone(),
                what,
                function: view.function.name.clone(),
            });
        }
        let name = self.texts.file.fill(|_| tree.title.clone());
        let environment = self.environment()?;
        let template = environment.get_template(TEMPLATE);
        let text = template.and_then(|template| template.render(view::root(tree)));
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

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Function;
    use robovec_ir::parse::parse_module;

    const TEXTS: &str = r#"
        file = "{name}.f"
        nested = true
        from_one = true
        reserved = "y"
        [text]
        scalar = "{array}"
        vector = "{array}({index})"
        matrix = "{array}({row}, {column})"
        number = "{mantissa}d{exponent}"
        [operations]
        neg = "-{a}"
        add = "{a} + {b}"
        sub = "{a} - {b}"
        mul = "mul({a}, {b})"
    "#;

    const TEMPLATE: &str = "{{ name }} {{ inputs[1].name }} {{ statements | length }}\n\
        {% for s in statements %}\n{{ s.name }} = {{ s.text }}: {{ s.operation }}\
        {% for o in s.operands %} {{ o.kind }} {{ o.text }}{% endfor %}\n\n{% endfor %}\n\
        {% for a in outputs %}\n{% for e in a.elements %}\n{{ e.text }} = {{ e.value }} {{ e.is_set }}\n\
        {% endfor %}\n{% endfor %}\n";

    fn written(function: &str) -> Result<(String, String), TargetError> {
        written_after(function, |_| {})
    }

    fn written_after(
        function: &str,
        change: impl Fn(&mut Function),
    ) -> Result<(String, String), TargetError> {
        let folder = TargetFolder {
            name: "mine".to_owned(),
            description: TEXTS.to_owned(),
            template: TEMPLATE.to_owned(),
        };
        let text = format!("// robovec 1\nfunction f equations {{\n{function}}}\n");
        let mut module = parse_module("f", &text).expect("it is the text form");
        change(&mut module.functions[0]);
        CodeTarget::parse(&folder)?.file(View {
            tables: &module.tables,
            function: &module.functions[0],
        })
    }

    #[test]
    fn a_target_without_copies_reads_the_original() {
        let function = "in x\nin y[1..2]\nout M[1..2,1..2]\n\
            %a = x - (y[2] - -2e-30)\n%b = %a\n%c = -(%b + x*(%a + y[1]))\nM[1,2] = %c\n";
        let (name, text) = written(function).expect("it is written");
        assert_eq!(name, "f.f");
        let expected = "f y_1 2\n\
            a = x - (y_1(2) - -2.0d-30): sub input x value y_1(2) - -2.0d-30\n\
            c = -(a + mul(x, a + y_1(1))): neg value a + mul(x, a + y_1(1))\n\
            M(1, 1) = 0.0d0 False\nM(1, 2) = c True\n\
            M(2, 1) = 0.0d0 False\nM(2, 2) = 0.0d0 False\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn what_has_no_text_is_named() {
        let error = written("in x\nout c\n%unused = cos(x)\nc = sin(x)\n");
        assert_eq!(
            error.expect_err("it is refused").to_string(),
            "mine/target.toml has no text for 'sin', which 'f' needs"
        );
        let error = written_after("in x\nout c\nc = x\n", |function| {
            function.assignments[0].operand = function.constant(f64::INFINITY).into();
        });
        assert_eq!(
            error.expect_err("it is refused").to_string(),
            "mine/target.toml has no text for the number inf, which 'f' needs"
        );
    }
}
