//! The table of a conformance run: what was asked, whether it holds, and what was found.

/// One thing that is asked of a device.
#[derive(Clone, Debug)]
pub struct CheckRow {
    /// its name
    pub name: &'static str,
    /// whether it holds
    pub pass: bool,
    /// a description of what was found
    pub found: String,
}

/// The table.
#[derive(Clone, Debug, Default)]
pub struct CheckTable {
    /// in the order of the test
    pub rows: Vec<CheckRow>,
}

impl CheckTable {
    pub(super) fn row(&mut self, name: &'static str, pass: bool, found: impl Into<String>) {
        self.rows.push(CheckRow { name, pass, found: found.into() });
    }

    /// Rows that do not hold.
    pub fn failed(&self) -> usize {
        self.rows.iter().filter(|r| !r.pass).count()
    }
}
