//! Code generation as a pass.

mod casadi;

pub use casadi::DerivativeOrder;

use robovec_cgen::batch::{self, batch_files};
use robovec_cgen::c::{
    self, ElementOrder, Layout, Options, Real, Signature, SignatureError, Sines, StatementOrder,
};
use robovec_cgen::fpcore::fpcore;
use robovec_cgen::rolled::{self, RolledCircular, rolled_files};
use robovec_cgen::superword::SuperwordLanes;
use robovec_cgen::template::{CodeTarget, TargetError};
use robovec_fpga::rtl::{self, CrossbarChoice, RtlError, write_rtl};
use robovec_fpga::{Artifacts, FileContent, ImageError, foreign_format, write_images};
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Artifact, Context, Gives, Pass, PassError, TargetFolder};
use robovec_framework::{declare_pass, option_words};
use robovec_ir::states::Ranges;
use robovec_ir::{Format, Function, View};
use robovec_num::limits::NumberLimit;
use std::io;

option_words! {
    /// Target of the code.
    pub enum CodegenTarget {
        /// Memory images and their manifest, for the machine of elements.
        Mif = "mif",
        /// The machine of elements in Verilog, with its images.
        Rtl = "rtl",
        /// C99, for a processor.
        C = "c",
        /// C99 with loops where the function repeats itself.
        Rolled = "rolled",
        /// C that evaluates many states per call.
        Batch = "batch",
        /// FPCore, for tools that bound rounding errors.
        Fpcore = "fpcore",
        /// C for CasADi, with derivatives and sparsities.
        Casadi = "casadi",
        /// Rust without the standard library.
        Rust = "rust",
        /// Python with NumPy, for any number of states per call.
        Numpy = "numpy",
        /// Python with JAX, for `jit`, `vmap` and `grad`.
        Jax = "jax",
        /// MLIR in the dialects func, arith, math and memref.
        Mlir = "mlir",
        /// LLVM IR.
        Llvm = "llvm",
        /// The folder of `--target`.
        Template = "template",
    }
}

option_words! {
    /// Parameters of the model in batch code: shared by all states, or separate for each.
    pub enum Parameters {
        /// One set for all states.
        Shared = "shared",
        /// Every state has its own.
        Own = "own",
    }
}

/// Puts files into a folder that has the function's name.
struct FunctionFolder<'a> {
    name: &'a str,
    artifacts: &'a mut Vec<Artifact>,
}

impl Artifacts for FunctionFolder<'_> {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        self.artifacts
            .file(&format!("{}/{name}", self.name), content)
    }
}

declare_pass! {
    /// Writes the function out for the machine or for a processor.
    ///
    /// `target=mif` turns a placed function into memory images: for every
    /// processing element an instruction image with one word per cycle, for
    /// every memory an image of its initial data, and `manifest.json`, which
    /// lays out the instruction words and gives the address of every input,
    /// constant and output. `docs/images.md` is the contract with hardware and
    /// simulator. The images contain only the decisions of the placed text, and
    /// are refused where the machine's words cannot express it.
    ///
    /// `target=rtl` writes the machine itself beside them, for a function F
    /// into `F/rtl` (Verilog) and `F/img` (images as `.mif` and `.hex`);
    /// `docs/rtl.md` describes it. With `crossbar=pruned` only the pairs of
    /// source and write port are built that the schedule uses.
    ///
    /// `target=c` writes a C99 function and its header from any level; arrays
    /// count from 1. With `signature=robotran` its names, types and parameters
    /// are those of Robotran's function (`docs/c.md`), so that the file
    /// replaces Robotran's in a project of MBsysC; with `signature=plain` the
    /// arrays are the parameters. The body is cut into functions of about
    /// `part` operations, for whose length compilers are fast, in an `order`
    /// that reads values soon after they are made. With `sines=library
    /// order=program`, compiled with `-ffp-contract=off`, it gives the
    /// evaluator's results bit for bit.
    ///
    /// `target=rolled` writes the same function with loops where it repeats
    /// itself, as unrolled recursions do: the code of long chains then fits
    /// the instruction cache (`docs/c-rolled.md`). It has the plain signature
    /// and the results of plain C: bit for bit with `circular=library`, else
    /// with sines and cosines within one unit in the last place. Arrays must
    /// not overlap.
    ///
    /// `target=batch` writes C in which every operation computes `lanes` states
    /// (1, 4, 8 or 16) as one vector, with its own sines and cosines and
    /// drivers for any number of states (`docs/c-batch.md`). With
    /// `parameters=shared` the arrays `dpt`, `l`, `m`, `In` and `g` are the
    /// same for all states, and values that depend on them alone are computed
    /// once.
    ///
    /// `target=fpcore` writes FPCore, which Daisy, FPTaylor, Satire and Herbie
    /// read: one core for every output, computed in `number`, with the ranges
    /// of the scene as precondition.
    ///
    /// `target=casadi` writes one C file with the function, its `derivatives`
    /// and their sparsities, which `casadi.external` loads (`docs/casadi.md`).
    /// Outputs that are named as Jacobians of others (`Qq_q` beside `Qq`) are
    /// used as such; other derivatives are made by `differentiate`.
    ///
    /// `target=rust`, `numpy`, `jax`, `mlir` and `llvm` write one file by a
    /// template, in binary64 and in the order of the function, from any level
    /// (`docs/targets.md`); `target=template` does so by the template in the
    /// folder that `--target` names.
    ///
    /// With `superwords=2`, `3` or `4` operations of plain C, and of C for CasADi,
    /// that repeat in the sides of a mechanism are computed as vectors of so
    /// many numbers, which gcc and clang have; `auto` takes the number with the
    /// fewest instructions. Results stay equal bit for bit.
    ///
    /// With `base=0` plain C has arrays that count from 0, without gaps, in the
    /// order of `layout`: `row`, `column`, or `packed`, which keeps the upper
    /// triangle of symmetric outputs. With `sparse=true` elements of outputs
    /// that are always zero are not kept either, and the header holds row and
    /// column of all others.
    ///
    /// The function itself is not changed.
    pub struct Codegen("codegen") {
        /// Target of the code.
        pub target: CodegenTarget = CodegenTarget::Mif,
        /// Extent of the crossbar in Verilog.
        pub crossbar: CrossbarChoice = CrossbarChoice::Full,
        /// The type C code computes in; images follow the machine file.
        pub number: Real = Real::Double,
        /// States of a vector of batch code.
        pub lanes: u32 = 8 => NumberLimit::whole(
            1, 16, "processors have vectors of 1, 4, 8 and 16 numbers"),
        /// Parameters of the model in batch code: shared by all states, or separate for each.
        pub parameters: Parameters = Parameters::Shared,
        /// Way in which the C function is called.
        pub signature: Signature = Signature::Robotran,
        /// Method for sines and cosines in C.
        pub sines: Sines = Sines::Inline,
        /// The order of statements in C.
        pub order: StatementOrder = StatementOrder::Depth,
        /// Operations per function in C.
        pub part: u32 = 500 => NumberLimit::whole(
            1, 1_000_000, "compile time grows faster than the length of a function"),
        /// Index of the first element of an array in C.
        pub base: u32 = 1 => NumberLimit::whole(
            0, 1, "arrays count from 1, as Robotran's, or from 0"),
        /// Order of the elements of arrays that count from 0.
        pub layout: ElementOrder = ElementOrder::Row,
        /// Keeps only elements of outputs that can differ from zero.
        pub sparse: bool = false,
        /// Operations of equal structure that one vector of C computes.
        pub superwords: SuperwordLanes = SuperwordLanes::None,
        /// Derivatives in C for CasADi.
        pub derivatives: DerivativeOrder = DerivativeOrder::Second,
        /// Method of rolled code for sines and cosines of inputs.
        pub circular: RolledCircular = RolledCircular::Vector,
    }
    takes: [Equations, Atomic, Scheduled, Placed],
    gives: Gives::Same,
    class: Exact,
}

impl Pass for Codegen {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let before = context.artifacts.len();
        let view = context.tables.view(function);
        match self.target {
            _ if self.base == 0 && self.target != CodegenTarget::C => {
                let message = "only target=c has arrays that count from 0 on request";
                return Err(PassError::new(message).help("leave out base=0"));
            }
            CodegenTarget::Mif => {
                write_images(view, context.machine, None, context.artifacts).map_err(explain)?;
            }
            CodegenTarget::Rtl => {
                let mut folder = FunctionFolder {
                    name: &view.function.name,
                    artifacts: context.artifacts,
                };
                write_rtl(view, context.machine, self.crossbar, &mut folder)
                    .map_err(|error| explain_rtl(&error))?;
            }
            _ => {
                let files = self.files(function, context)?.into_iter();
                let files = files.map(|(name, text)| Artifact { name, text });
                context.artifacts.extend(files);
            }
        }
        let new = &context.artifacts[before..];
        let bytes = new.iter().map(|file| file.text.len() as u64).sum();
        context.count("files", new.len() as u64);
        context.count("bytes", bytes);
        Ok(())
    }
}

fn explain_rtl(error: &RtlError) -> PassError {
    let explained = PassError::new(error.to_string());
    match rtl::advice(error) {
        Some(help) => explained.help(help),
        None => explained,
    }
}

impl Codegen {
    /// The files of a target that computes in the format of a processor.
    fn files(
        &self,
        function: &Function,
        context: &mut Context<'_>,
    ) -> Result<Vec<(String, String)>, PassError> {
        let view = context.tables.view(function);
        self.check_format(view)?;
        Ok(match self.target {
            CodegenTarget::C if self.sparse => {
                let function = &c::layout::without_zeros(function.clone());
                let view = View { function, ..view };
                c::files(view, &self.options()?).map_err(refuse)?.into()
            }
            CodegenTarget::C => c::files(view, &self.options()?).map_err(refuse)?.into(),
            CodegenTarget::Rolled => {
                let options = rolled::Options {
                    real: self.number,
                    circular: self.circular,
                };
                let rolled = rolled_files(view, options)
                    .map_err(|error| PassError::new(error.to_string()))?;
                context.statistics.extend(rolled.summary.statistics());
                rolled.files.into()
            }
            CodegenTarget::Batch => batch_files(view, &self.batch_options()?).into(),
            CodegenTarget::Fpcore => {
                let none = Ranges::default();
                let ranges = context.scene.map_or(&none, |scene| &scene.ranges);
                let name = format!("{}.fpcore", view.function.name);
                let text = fpcore(view, self.number, ranges).ok_or_else(|| {
                    PassError::new("the cores of all outputs together are too large, because they repeat shared operations")
                        .help("keep the outputs that are needed: a scene and 'specialise'")
                })?;
                vec![(name, text)]
            }
            CodegenTarget::Casadi => {
                let options = self.casadi_options()?;
                let file = casadi::file(function, self.derivatives, &options, context)?;
                vec![(file.name, file.text)]
            }
            _ => vec![self.templated(view, context.target)?],
        })
    }

    /// Refuses a value in another format than that of the code.
    fn check_format(&self, view: View<'_>) -> Result<(), PassError> {
        let own = match self.number {
            Real::Double => Format::BINARY64,
            Real::Float => Format::BINARY32,
        };
        let Some((value, format)) = foreign_format(view, own) else {
            return Ok(());
        };
        let code = match self.target {
            CodegenTarget::Fpcore => "FPCore",
            CodegenTarget::C
            | CodegenTarget::Rolled
            | CodegenTarget::Batch
            | CodegenTarget::Casadi => "C code",
            _ => "generated code",
        };
        let message = format!(
            "'%{value}' is computed as {format}, and the {code} computes in {}",
            self.number.name()
        );
        Err(PassError::new(message).help("set formats of values only for a machine"))
    }

    /// The options of batch code.
    fn batch_options(&self) -> Result<batch::Options, PassError> {
        if !batch::LANES.contains(&self.lanes) {
            let message = format!("vectors of {} lanes do not exist", self.lanes);
            return Err(PassError::new(message).help("choose 1, 4, 8 or 16"));
        }
        let defaults = batch::Options::default();
        Ok(batch::Options {
            real: self.number,
            lanes: self.lanes,
            shared: match self.parameters {
                Parameters::Shared => defaults.shared,
                Parameters::Own => Vec::new(),
            },
            ..defaults
        })
    }

    /// The options of C code.
    fn options(&self) -> Result<Options, PassError> {
        self.check_superwords()?;
        let options = Options {
            signature: self.signature,
            real: self.number,
            sines: self.sines,
            order: self.order,
            part: self.part,
            superwords: self.superwords,
            ..Options::default()
        };
        if self.base == 0 {
            return Ok(Options {
                signature: Signature::Plain,
                layout: Layout::FromZero {
                    order: self.layout,
                    is_sparse: self.sparse,
                },
                ..options
            });
        }
        if self.layout != ElementOrder::Row || self.sparse {
            let message = "arrays that count from 1 have rows with all elements";
            return Err(PassError::new(message).help("add base=0"));
        }
        Ok(options)
    }

    /// Refuses superwords in the function's order, in which the lanes of one are
    /// far apart.
    fn check_superwords(&self) -> Result<(), PassError> {
        let is_in_order = self.order == StatementOrder::Program;
        if is_in_order && self.superwords != SuperwordLanes::None {
            let message = "superwords need order=depth";
            return Err(PassError::new(message).help("leave out order=program"));
        }
        Ok(())
    }

    /// The file that a template makes: its name and text.
    fn templated(
        &self,
        view: View<'_>,
        folder: Option<&TargetFolder>,
    ) -> Result<(String, String), PassError> {
        if self.number == Real::Float {
            return Err(PassError::new("templates compute in 'double'")
                .help("leave out number=float, or choose target=c"));
        }
        let explain = |error: TargetError| PassError::new(error.to_string()).help(error.advice());
        let target = match (self.target, folder) {
            (CodegenTarget::Template, Some(folder)) => {
                CodeTarget::parse(folder).map_err(explain)?
            }
            (CodegenTarget::Template, None) => {
                return Err(
                    PassError::new("target=template needs the folder of a target")
                        .help("name it with '--target FOLDER'"),
                );
            }
            (shipped, _) => CodeTarget::built_in(&shipped.print()),
        };
        target.file(view).map_err(explain)
    }

    /// The options of C for CasADi, which computes in binary64.
    fn casadi_options(&self) -> Result<Options, PassError> {
        self.check_superwords()?;
        match self.number {
            Real::Double => Ok(Options {
                sines: self.sines,
                order: self.order,
                part: self.part,
                superwords: self.superwords,
                ..Options::default()
            }),
            Real::Float => Err(PassError::new("CasADi computes in 'double'")
                .help("leave out number=float, or choose target=c")),
        }
    }
}

fn refuse(error: SignatureError) -> PassError {
    let help = match &error {
        SignatureError::Sensor(_) | SignatureError::Call { .. } => {
            "'robovec gen --language c' writes such files in one piece"
        }
        _ => "with signature=plain the arrays are the parameters",
    };
    PassError::new(error.to_string()).help(help)
}

fn explain(error: ImageError) -> PassError {
    let help = match &error {
        ImageError::NotPlaced { .. } => Some("run 'place' before, or choose target=c".to_owned()),
        ImageError::OtherMachine(mismatch) => Some(mismatch.advice()),
        _ => None,
    };
    let explained = PassError::new(error.to_string());
    match help {
        Some(help) => explained.help(help),
        None => explained,
    }
}
