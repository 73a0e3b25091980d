//! Anchors of headings, as GitHub makes them.

use std::collections::HashMap;

/// Makes the anchors of the headings of one page, in their order.
#[derive(Default)]
pub(crate) struct Anchors(HashMap<String, usize>);

impl Anchors {
    /// Returns the anchor of the next heading. A heading that repeats an earlier one gets a number.
    pub(crate) fn next(&mut self, heading: &str) -> String {
        let anchor = anchor(heading);
        let seen = self.0.entry(anchor.clone()).or_default();
        *seen += 1;
        if *seen > 1 { format!("{anchor}-{}", *seen - 1) } else { anchor }
    }
}

/// Returns the anchor of a heading.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_are_those_of_github() {
        let mut anchors = Anchors::default();
        for (heading, want) in [
            ("Edit and hear", "edit-and-hear"),
            ("`ca play`, with a 2nd page", "ca-play-with-a-2nd-page"),
            ("Methods: what is stiff, viscous, or should be exact", "methods-what-is-stiff-viscous-or-should-be-exact"),
            ("Edit and hear", "edit-and-hear-1"),
            ("Edit and hear", "edit-and-hear-2"),
        ] {
            assert_eq!(anchors.next(heading), want);
        }
    }
}
