//! Gives something another name, in its definition and in everything that refers to it.

use crate::layout::key;
use crate::symbols::{Class, Symbol, Written};
use crate::{Edited, Refusal, TextEdit};

/// Renames what is called `name` to `to`, one word. Names in other files stay as they are.
///
/// # Errors
/// If the name is unknown, the new one is not free, or the new name would mean something else at one of its places.
pub(crate) fn rename(w: &Written, name: &str, to: &str) -> Result<Edited, Refusal> {
    let symbol = w.find(name)?;
    let old = w.name(symbol);
    if old == to {
        return Ok(Edited::new(w.text(), Vec::new()));
    }
    let own = match (symbol.class, old.split_once('.')) {
        (Class::Module, Some((group, word))) if w.named(symbol.scope, group).is_some() => {
            if word == to {
                return Ok(Edited::new(w.text(), Vec::new()));
            }
            format!("{group}.{to}")
        }
        (_, Some(_)) => {
            let help = "write the instances as `[use]`, and rename the module in the part";
            return Err(Refusal::new(format!("`{name}` is a member of an instance, written out"), help));
        }
        _ => to.to_owned(),
    };
    if to.contains('.') {
        let help = "give one word; to move a module to a part, use `group`";
        return Err(Refusal::new(format!("`{}` is not one word", to.escape_debug()), help));
    }
    check(w, symbol, &own)?;
    let path = w.path(symbol);
    let mut edits = Vec::new();
    w.document.tree().words(&mut |at, word| {
        if at == path {
            edits.push(TextEdit::new(word.range.clone(), key(to)));
        }
    });
    let before = w.references();
    edits.extend(before.iter().filter_map(|r| w.rewrite(r, &|s| (s == symbol).then(|| to.to_owned()))));
    let edited = Edited::new(w.text(), edits);
    let now = Written::read(&edited.text, w.catalog)?;
    // indices of symbols do not depend on names, so every reference must mean the same as before
    let after = now.references();
    let same = |(a, b): (&crate::references::Reference, &crate::references::Reference)| {
        a.hits.iter().map(|h| h.symbol).eq(b.hits.iter().map(|h| h.symbol))
    };
    if before.len() == after.len() && before.iter().zip(&after).all(same) {
        return Ok(edited);
    }
    let what = format!("`{to}` already has another meaning where `{old}` is used");
    Err(Refusal::new(what, "choose another name: a part, an instance, a unit or a note has this one"))
}

fn check(w: &Written, symbol: Symbol, name: &str) -> Result<(), Refusal> {
    if matches!(symbol.class, Class::Part | Class::Preset) {
        let taken = w.find(&format!("{}.{name}", if symbol.class == Class::Part { "part" } else { "preset" })).is_ok();
        if taken {
            return Err(Refusal::new(format!("`{name}` is already used"), "choose another name"));
        }
        if !ca_model::select::is_word(name) {
            return w.check_free(symbol.scope, name);
        }
        return Ok(());
    }
    if symbol.class == Class::Group && name.starts_with(|c: char| c.is_ascii_uppercase()) {
        return Err(Refusal::new(format!("`{name}` is not the name of a group"), "begin it with a lower-case letter"));
    }
    w.check_free(symbol.scope, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINE: &str = r#"# a model
[param]
felt = { value = "8 kN/m", live = true } # felt of the hammer
place = 0.3

[preset.hard]
felt = "20 kN/m"

[STRING]
low = { n = 40, f = "110 Hz", m = "1 g" }

[part.arm]
gravity = "felt"
[part.arm.param]
f = { value = 1 }
on = {}
[part.arm.TGR]
key = { x = "-2 mm" }
[part.arm.MAS]
head = { m = "2 f" }
[part.arm.RES]
pull = { between = ["key", 'low[4]'], k = "felt" }
push = { between = ["head", "on"], k = "felt" }

[use]
one = { part = "arm", n = 2, with = { on = "low[3]", f = [1, 2] } }

[use.two]
part = "arm"
with.on = "low@place"

[beads.MAS]
a = { m = "1 g" }

[RES]
tie = { between = [["beads.a", "one[*].head", "two.head"], "low[-1]"], k = "2 felt" }

[SOX]
out = { from = "low.link[0]", minus = "one[0].head" }

[gesture]
"one[0..2].key" = [[0, 0]]
two.key = { follow = "one[0].key" }
felt = [[0, 1]]

[equivalence.two.key]
lever = 2
"#;

    fn renamed(name: &str, to: &str) -> Result<String, String> {
        let catalog = ca_model::catalog();
        let w = Written::read(MINE, &catalog).unwrap();
        rename(&w, name, to).map(|e| e.text).map_err(|e| e.to_string())
    }

    #[test]
    fn all_references_follow() {
        let all = |pairs: &[(&str, &str)]| pairs.iter().fold(MINE.to_owned(), |t, (a, b)| t.replace(a, b));
        let felt = [("\nfelt =", "\nhard_felt ="), ("\"felt\"", "\"hard_felt\""), ("2 felt", "2 hard_felt")];
        assert_eq!(renamed("felt", "hard_felt").unwrap(), all(&felt));
        let low = [("\nlow ", "\nE2_ "), ("low[", "E2_["), ("low@", "E2_@"), ("low.", "E2_.")];
        assert_eq!(renamed("low", "E2_").unwrap(), all(&low));
        assert_eq!(renamed("one", "first").unwrap(), all(&[("\none ", "\nfirst "), ("\"one[", "\"first[")]));
        let two = [("use.two", "use.x"), ("\"two.", "\"x."), ("\ntwo.", "\nx."), ("equivalence.two", "equivalence.x")];
        assert_eq!(renamed("two", "x").unwrap(), all(&two));
        assert_eq!(renamed("beads", "pearls").unwrap(), all(&[("beads", "pearls")]));
        assert_eq!(renamed("beads.a", "bb").unwrap(), all(&[("\na =", "\nbb ="), ("beads.a", "beads.bb")]));
        let key =
            [("\nkey =", "\nlever_ ="), ("\"key\"", "\"lever_\""), ("].key", "].lever_"), ("two.key", "two.lever_")];
        assert_eq!(renamed("part.arm.key", "lever_").unwrap(), all(&key));
        assert_eq!(
            renamed("part.arm.head", "h").unwrap(),
            all(&[("\nhead", "\nh"), ("\"head\"", "\"h\""), (".head", ".h")])
        );
        let f = [("\nf =", "\npitch ="), ("2 f\"", "2 pitch\""), (", f =", ", pitch =")];
        assert_eq!(
            renamed("part.arm.f", "pitch").unwrap(),
            all(&[f.as_slice(), &[("n = 40, pitch", "n = 40, f")]].concat())
        );
        assert_eq!(
            renamed("part.arm.on", "at").unwrap(),
            all(&[("\non =", "\nat ="), ("\"on\"", "\"at\""), ("{ on =", "{ at ="), ("with.on", "with.at")])
        );
        assert_eq!(renamed("part.arm", "lift").unwrap(), all(&[("part.arm", "part.lift"), ("\"arm\"", "\"lift\"")]));
        assert_eq!(renamed("place", "spot").unwrap(), all(&[("\nplace", "\nspot"), ("@place", "@spot")]));
        assert_eq!(renamed("preset.hard", "soft").unwrap(), all(&[("preset.hard", "preset.soft")]));
        assert_eq!(renamed("tie", "tie").unwrap(), MINE);
    }

    #[test]
    fn a_name_that_would_mean_something_else_is_refused() {
        for (name, to) in [("low", "key"), ("low", "on"), ("felt", "m"), ("felt", "f"), ("low", "tie")] {
            let why = renamed(name, to).unwrap_err();
            assert!(why.contains("already"), "{name} to {to}: {why}");
        }
        assert!(renamed("beads", "Beads").unwrap_err().contains("lower-case"));
        for to in ["", "a b", "é", "a.b", "\"", "1a", "model", "MAS", "a\nb", &"x".repeat(200)] {
            assert!(renamed("low", to).is_err(), "{to}");
        }
        assert!(renamed("lo", "x").unwrap_err().contains("did you mean `low`?"));
    }
}
