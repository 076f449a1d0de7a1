//! Names of files that promise another content than they would get.

use super::CommandFailure;
use std::path::Path;

/// Ends of names of files that robovec's own text is not.
const OTHER_LANGUAGES: [&str; 14] = [
    "c", "h", "m", "py", "rs", "mlir", "ll", "v", "sv", "mif", "hex", "json", "toml", "mbs",
];

/// Refuses to put a result into a file whose name promises another language:
/// robovec's text into `x.c`, or C into `x.rvir`.
pub(super) fn refuse_wrong(path: &Path, is_text: bool) -> Result<(), CommandFailure> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
    let path = path.display();
    if is_text && OTHER_LANGUAGES.contains(&end) {
        let advice = match end {
            "c" | "h" => "for C, end the pipeline with codegen{target=c} and name a folder",
            "mif" | "hex" => "for images, end the pipeline with place,codegen{target=mif}",
            "v" | "sv" => "for hardware, end the pipeline with place,codegen{target=rtl}",
            "rs" => "for Rust, end the pipeline with codegen{target=rust}",
            "mlir" => "for MLIR, end the pipeline with codegen{target=mlir}",
            "ll" => "for LLVM IR, end the pipeline with codegen{target=llvm}",
            "m" | "py" => "'robovec gen' writes Matlab and Python",
            _ => "reports go into other files: --report FILE",
        };
        let notes = vec![
            "robovec's text goes into a file whose name ends in .rvir".to_owned(),
            advice.to_owned(),
        ];
        let message = format!(
            "the result is robovec's text, which cannot be written to a file with the name {path}"
        );
        return Err(CommandFailure::advised(message, notes));
    }
    if !is_text && end == "rvir" {
        return Err(CommandFailure::advised(
            format!("the result is generated code, but the name {path} is for robovec's text"),
            vec![
                "give it the ending of its language, for example x.c, or leave 'codegen' out"
                    .to_owned(),
            ],
        ));
    }
    Ok(())
}

/// Refuses to make a folder with the name of a file: C is a source and a
/// header, images are many files.
pub(super) fn refuse_for_several(folder: &Path, count: usize) -> Result<(), CommandFailure> {
    let end = folder.extension().and_then(|end| end.to_str());
    let is_file = end.is_some_and(|end| end == "rvir" || OTHER_LANGUAGES.contains(&end));
    if !is_file || folder.is_dir() {
        return Ok(());
    }
    Err(CommandFailure::advised(
        format!(
            "the pipeline made {count} files, and {} is a name for one",
            folder.display()
        ),
        vec!["name a folder for them: -o FOLDER".to_owned()],
    ))
}
