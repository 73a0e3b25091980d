//! The ordered list of all kinds of a build, and the list of sources they cite.
//!
//! Each crate lists its kinds in one place. Readers of models combine them: `ca_model::catalog().with(ca_lpr::KINDS)`.

use crate::kind::Kind;
use alloc::vec::Vec;

/// Papers and programs cited by the kinds: key and full reference.
pub const SOURCES: &[(&str, &str)] = &[
    (
        "CMJ 1984",
        "C. Cadoz, A. Luciani, J.-L. Florens, Responsive input devices and sound synthesis by simulation of instrumental mechanisms: the CORDIS system, Computer Music Journal 8(3), 1984",
    ),
    (
        "CMJ 1993",
        "C. Cadoz, A. Luciani, J.-L. Florens, CORDIS-ANIMA: a modeling and simulation system for sound and image synthesis, Computer Music Journal 17(1), 1993",
    ),
    (
        "SMC 2007",
        "A. Kontogeorgakopoulos, C. Cadoz, CORDIS ANIMA physical modeling and simulation system analysis, Sound and Music Computing, 2007",
    ),
    (
        "ICMC 2013",
        "J. Leonard, N. Castagné, C. Cadoz, J.-L. Florens, Interactive physical design and haptic playing of virtual musical instruments, ICMC, 2013, hal-01089222",
    ),
    (
        "LAC 2019",
        "J. Leonard, J. Villeneuve, R. Michon, Y. Orlarey, S. Letz, Formalizing mass-interaction physical modeling in Faust, Linux Audio Conference, 2019",
    ),
    (
        "SMC 2019",
        "J. Leonard, J. Villeneuve, mi-gen~: an efficient and accessible mass-interaction sound synthesis toolbox, Sound and Music Computing, 2019",
    ),
    (
        "Rattle",
        "Sharp colliding of multiple sound objects with haptic feedback: a child rattle, section 2.2, radial projection coupling (LPR)",
    ),
    (
        "HSP v2",
        "E. Berdahl, A. Kontogeorgakopoulos, D. Overholt, HSP v2: haptic signal processing with extensions for physical modeling",
    ),
    (
        "Hunt 1975",
        "K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, J. Applied Mechanics 42, 1975",
    ),
    ("Bilbao 2009", "S. Bilbao, Numerical Sound Synthesis, Wiley, 2009"),
];

/// All kinds of a build, in the order of the documentation.
#[derive(Clone, Debug)]
pub struct Catalog {
    kinds: Vec<&'static Kind>,
}

impl Catalog {
    /// Returns the kinds of this crate: MATs, LIAs and ports. `ca_model::catalog()` adds the generators.
    pub fn core() -> Catalog {
        let lists = [crate::mat::KINDS, crate::phi::KINDS, crate::io::KINDS];
        Catalog { kinds: lists.concat() }
    }

    /// Adds the kinds of another crate.
    ///
    /// # Panics
    /// If a code is already taken, since a model could name only the first kind with this code.
    #[must_use]
    pub fn with(mut self, kinds: &[&'static Kind]) -> Catalog {
        for kind in kinds {
            let first = self.get(kind.code);
            assert!(
                first.is_none(),
                "two kinds have the code `{}`: \"{}\" and \"{}\"; codes must be unique, so rename one of them",
                kind.code,
                first.map_or("", |k| k.title),
                kind.title
            );
            self.kinds.push(kind);
        }
        self
    }

    /// Returns the kind with this code.
    pub fn get(&self, code: &str) -> Option<&'static Kind> {
        self.kinds.iter().copied().find(|k| k.code == code)
    }

    /// Iterates over all kinds.
    pub fn iter(&self) -> impl Iterator<Item = &'static Kind> + '_ {
        self.kinds.iter().copied()
    }
}
