//! Expander: a model whose parts are being put in, and what is known of them meanwhile.
//!
//! Decides that this one record is what finding a part, measuring it and putting it in all work on, each in a file of its own
//! above this one.

use crate::diag::{Diag, Diags};
use crate::model::{LARGEST, Model, Span};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use ca_core::internal::kind::cloud::Unread;

/// A file whose parts may be used.
pub(super) struct Home {
    /// its path from the folder of the model; of the model itself there is none
    pub file: String,
    /// its parts, and for another file its modules too
    pub model: Model,
}

impl Home {
    /// The folder of its file, with a slash.
    pub fn folder(&self) -> &str {
        self.file.rfind('/').map_or("", |i| &self.file[..=i])
    }
}

/// Modules, instances.
pub(super) type Size = [usize; 2];

/// What a file holds, by its path from the folder of the model.
pub(crate) type Open<'f> = &'f mut dyn FnMut(&str) -> Result<String, Unread>;

/// A model whose parts are put in.
pub(super) struct Expander<'e> {
    pub catalog: &'e Catalog,
    pub open: Open<'e>,
    pub model: Model,
    pub diags: Diags,
    /// files that were asked for; what cannot be read has been reported
    pub files: BTreeMap<String, Option<Rc<Home>>>,
    /// parameters and modules at the root
    pub root: BTreeSet<String>,
    /// what an instance of a part makes, by file and name
    pub sizes: BTreeMap<(String, String), Size>,
    /// there are too many of them
    pub over: bool,
    /// the parts that are being put in, each in the one before: file and name
    pub within: Vec<(String, String)>,
}

impl Expander<'_> {
    /// Whether nothing more is put in.
    pub fn is_over(&self) -> bool {
        self.over || self.diags.is_full()
    }

    pub fn too_many(&mut self, at: Span) {
        self.over = true;
        if !self.diags.list.iter().any(|d| d.code == "E027") {
            let d =
                Diag::error("E027", format!("more than {LARGEST} modules, with those of parts")).at(at, "from here on");
            self.diags.push(d.help("a model holds no more, and a real-time one some thousands"));
        }
    }
}
