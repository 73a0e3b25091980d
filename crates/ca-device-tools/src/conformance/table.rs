//! Results of a conformance run.

/// One requirement on a device.
#[derive(Clone, Debug)]
pub struct CheckRow {
    /// Name of the requirement.
    pub name: &'static str,
    /// True if it is met.
    pub pass: bool,
    /// Description of the finding.
    pub found: String,
}

/// Results of all tests.
#[derive(Clone, Debug, Default)]
pub struct CheckTable {
    /// Requirements, in the order of the test.
    pub rows: Vec<CheckRow>,
}

impl CheckTable {
    pub(super) fn row(&mut self, name: &'static str, pass: bool, found: impl Into<String>) {
        self.rows.push(CheckRow { name, pass, found: found.into() });
    }

    /// Returns the number of requirements that are not met.
    pub fn failed(&self) -> usize {
        self.rows.iter().filter(|r| !r.pass).count()
    }
}
