//! Blocks of code in documents.

/// A fenced block.
pub(crate) struct CodeBlock {
    /// Kind of the block: the first word of the fence, or the second after
    /// `text`. Highlighters of books warn of languages that they do not know.
    pub(crate) kind: String,
    /// The other words: the context of a fragment.
    pub(crate) note: String,
    pub(crate) text: String,
    /// Its first line in the document, from 1.
    pub(crate) line: usize,
}

/// The blocks of a document. Code is fenced: a fence names the kind of content,
/// and four spaces do not.
pub(crate) fn blocks(document: &str) -> Result<Vec<CodeBlock>, String> {
    let mut blocks = Vec::new();
    let mut open: Option<CodeBlock> = None;
    let mut before = "";
    for (number, line) in document.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(words)) => {
                let words = words.strip_prefix("text ").unwrap_or(words);
                let (kind, note) = words.split_once(' ').unwrap_or((words, ""));
                open = Some(CodeBlock {
                    kind: kind.to_owned(),
                    note: note.to_owned(),
                    text: String::new(),
                    line: number + 2,
                });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => {
                block.text += line;
                block.text.push('\n');
            }
            (None, None) if line.starts_with("    ") && before.trim().is_empty() => {
                return Err(format!("line {}: code stands between fences", number + 1));
            }
            (None, None) => {}
        }
        before = line;
    }
    match open {
        Some(block) => Err(format!("line {}: the fence is not closed", block.line)),
        None => Ok(blocks),
    }
}

/// The commands of a block for the shell, without the text after ` # `.
pub(crate) fn commands(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let lines = joined.lines().map(|line| {
        if line.starts_with('#') {
            ""
        } else {
            line.split(" # ").next().unwrap_or_default().trim()
        }
    });
    lines
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect()
}
