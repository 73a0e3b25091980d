//! Resolves the codes in a plan to laws, kinds and units.

use crate::catalog::Catalog;
use crate::kind::{Kind, MatSpec, Role, Type, Unit};
use crate::op::Law;
use crate::op::family;
use crate::phi;
use crate::scene::symbols::MODE;
use alloc::vec::Vec;

pub(super) struct Known<'a> {
    catalog: &'a Catalog,
    laws: Vec<&'static Law>,
}

impl Known<'_> {
    pub(super) fn new(catalog: &Catalog) -> Known<'_> {
        let laws = catalog.iter().filter_map(law).flat_map(family).chain([&phi::implicit::LAW]).collect();
        Known { catalog, laws }
    }

    /// Returns a law for links. Laws of one code run alike.
    pub(super) fn law(&self, code: &str) -> Option<&'static Law> {
        self.laws.iter().copied().find(|law| law.code == code)
    }

    pub(super) fn kind(&self, code: &str) -> Option<&'static Kind> {
        self.catalog.get(code)
    }

    /// Returns a kind of MAT and its rule for coefficients.
    pub(super) fn mat(&self, code: &str) -> Option<(&'static Kind, &'static MatSpec)> {
        self.catalog.iter().find_map(|kind| match kind.role {
            Role::Mat(spec) if spec.code == code => Some((kind, spec)),
            _ => None,
        })
    }

    pub(super) fn code(&self, code: &str) -> Option<&'static str> {
        let kinds = self.catalog.iter().map(|kind| kind.code);
        self.laws.iter().map(|law| law.code).chain(kinds).chain([MODE]).find(|known| *known == code)
    }

    pub(super) fn symbol(&self, symbol: &str) -> Option<&'static str> {
        let of_params = self.catalog.iter().flat_map(|kind| kind.params).filter_map(|param| match param.ty {
            Type::Number { unit, .. } => Some(unit.symbol),
            _ => None,
        });
        let named = Unit::NAMED.iter().map(|unit| unit.symbol);
        named.chain(Unit::POWERS).chain([Unit::ANY_POWER]).chain(of_params).find(|known| *known == symbol)
    }
}

/// Returns a law for the parameters of items of `kind`. Links of a generator have the parameters of REF.
pub(super) fn law_of(kind: &'static Kind, code: &str) -> Option<&'static Law> {
    let own = law(kind).unwrap_or(&phi::ref_::LAW);
    family(own).into_iter().chain([&phi::implicit::LAW]).find(|law| law.code == code)
}

fn law(kind: &'static Kind) -> Option<&'static Law> {
    if let Role::Lia(law) = kind.role { Some(law) } else { None }
}
