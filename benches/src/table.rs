//! Tables of the pages, in Markdown.

/// Formats a row.
pub fn line(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// Formats the names of the columns, and the rule below them.
pub fn head(columns: &[&str]) -> String {
    format!("| {} |\n{}|\n", columns.join(" | "), "|---".repeat(columns.len()))
}
