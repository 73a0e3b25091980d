//! Names that a model does not have: what was meant, or where to declare it.

use crate::connect::select::Written;
use crate::connect::wiring::Wiring;
use alloc::format;
use alloc::string::ToString;
use ca_core::internal::kind::PortRole;
use ca_core::{Kind, Role};
use ca_model::Item;
use ca_model::diag::Diag;
use ca_model::part::Use;
use ca_model::select;
use ca_model::suggest::nearest;

/// Owner of the selectors of requested probes.
pub(super) const PROBE: &str = "probe";

impl<'a> Wiring<'a> {
    /// Returns whether the name is in the model but broken, which was reported at its place.
    pub(super) fn is_reported(&mut self, name: &str) -> bool {
        let broken = self.broken.contains(name);
        if broken && self.net.incomplete.is_none() {
            self.net.incomplete = Some(name.into());
        }
        broken
    }

    pub(super) fn unknown(&mut self, name: &str, w: Written<'_>, wants_mat: Option<&str>) {
        if self.is_reported(name) {
            return;
        }
        let known = self.net.items.iter().find(|i| *i.name == *name).map(|i| (i.kind, i.model));
        if let Some((kind, at)) = known {
            if let Role::Generator(_) = kind.role {
                // The generator could not be built, which was reported.
                self.net.incomplete.get_or_insert_with(|| name.into());
                return;
            }
            let d = Diag::error("E017", format!("`{}`: `{name}` is {}, not a mass", w.owner, family_of(kind)));
            let d =
                d.at(w.span, format!("{} is not a MAT", kind.code)).at(self.model.items[at].name_span, "declared here");
            self.diags.push(match wants_mat {
                Some(why) => d.help(why),
                None => d.help("name a MAT, a LIA or a port that is moved from outside"),
            });
            return;
        }
        let d = Diag::error("E013", format!("`{}`: no module `{name}`", w.owner)).at(w.name(name), "unknown");
        // The group of any instance represents all of them.
        let many = |g: &str| g.strip_prefix(name).is_some_and(|r| r.starts_with('['));
        let is = |g: &&str| *g == w.text.trim() || *g == name || many(g);
        let group = self.model.groups.iter().map(|g| g.name.as_str()).find(is);
        let known = self.net.families.names();
        let member = known.iter().copied().find(|k| k.rsplit('.').next() == Some(name));
        // Broken modules are suggested too.
        let names = known.iter().copied().chain(self.broken.iter().copied());
        let near = member.or_else(|| self.of_instance(name, w.owner)).or_else(|| nearest(name, names));
        let d = if self.model.params.iter().any(|p| p.key == name) {
            d.help("that is a parameter; name a module instead")
        } else if let Some(group) = group {
            let first = known.iter().find(|k| k.starts_with(&format!("{group}.")));
            let first = first.map_or_else(|| format!("{group}.…"), ToString::to_string);
            d.help(format!("that is a group; name one of its modules, e.g. `{first}`"))
        } else if let Some(u) = self.model.uses.iter().find(|u| u.n.is_some() && is_of(name, &u.name)) {
            let rest = name.get(u.name.len()..).unwrap_or("");
            d.help(format!("`{0}` has instances: write `{0}[0]{rest}` for one of them, `{0}[*]{rest}` for all", u.name))
        } else if select::is_word(name) && self.model.gestures.iter().any(|g| g.key == name) {
            d.help(format!("a gesture drives this name: declare it, e.g. `{name} = {{}}` under `[ENX]`"))
        } else if let Some(near) = near.filter(|_| !self.is_as_written(w)) {
            // The text was generated from another one and cannot be replaced in place.
            d.help(format!("did you mean `{near}`?"))
        } else if let Some(near) = near {
            // If the span is the whole text, the fix includes the quotes.
            let span = w.name(name);
            let new = if span == w.span { format!("\"{near}\"") } else { near.to_string() };
            d.help(format!("did you mean `{near}`?")).fix(span, new)
        } else if let Some((whole, _)) = w.text.trim().rsplit_once('.').filter(|(whole, _)| self.is_module(whole)) {
            d.help(format!("`{whole}` exists: write only `{whole}`"))
        } else if (w.owner == PROBE && !w.span.is_some()) || !select::is_word(name) {
            d.help("name a module of the model")
        } else {
            let under =
                if self.is_in_part(w.owner) { "in the part, or in the model under `[MAS]`" } else { "under `[MAS]`" };
            d.help(format!("declare it, e.g. `{name} = {{ m = \"20 g\" }}` {under}"))
        };
        self.diags.push(d);
    }

    /// Returns whether `text` selects masses or links that exist.
    fn is_module(&self, text: &str) -> bool {
        select::parse(text).is_ok_and(|sel| self.net.families.get(&sel.name).is_some())
    }

    /// Returns whether the source contains the text as it is, unlike names made for lists of instances or values of
    /// parts.
    fn is_as_written(&self, w: Written<'_>) -> bool {
        let source = self.model.source(w.span);
        let at = source.to_text_span(w.span);
        !w.span.is_some() || source.text.get(at.start..at.end).is_none_or(|t| t.contains(w.text))
    }

    /// Returns the module of a part with a name similar to `name`, if `owner` is in an instance of that part.
    fn of_instance(&self, name: &str, owner: &str) -> Option<&'a str> {
        let (instance, _) = owner.rsplit_once('.').filter(|_| self.is_in_part(owner))?;
        let own = |i: &'a Item| i.name.strip_prefix(instance).and_then(|r| r.strip_prefix('.'));
        nearest(name, self.model.items.iter().filter_map(own))
    }

    /// Returns whether `name` belongs to an instance of a part.
    pub(super) fn is_in_part(&self, name: &str) -> bool {
        let of = |u: &Use| name.strip_prefix(u.name.as_str()).is_some_and(|r| r.starts_with(['.', '[']));
        self.model.uses.iter().any(of)
    }
}

/// Returns whether `name` is within `of`.
fn is_of(name: &str, of: &str) -> bool {
    name.strip_prefix(of).is_some_and(|r| r.starts_with('.'))
}

fn family_of(kind: &Kind) -> &'static str {
    match kind.role {
        Role::Lia(_) => "a link",
        Role::Port(PortRole::Sox | PortRole::Sof) => "an output",
        Role::Port(PortRole::Enf) => "a force",
        _ => "another kind of module",
    }
}
