//! State of a model while its parts are put in. `find`, `size` and `instance` work on it.

use crate::diag::{Diag, Diags};
use crate::model::{LARGEST, Model, Span};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use ca_core::internal::kind::cloud::Unread;

pub(super) struct Home {
    /// Path from the folder of the model; empty for the model itself.
    pub file: String,
    /// Its parts, and for another file its modules too.
    pub model: Model,
}

impl Home {
    /// Returns the folder of the file, with a slash.
    pub fn folder(&self) -> &str {
        self.file.rfind('/').map_or("", |i| &self.file[..=i])
    }
}

/// Number of modules and of instances.
pub(super) type Size = [usize; 2];

/// Returns the content of a file by its path from the folder of the model.
pub(crate) type Open<'f> = &'f mut dyn FnMut(&str) -> Result<String, Unread>;

pub(super) struct Expander<'e> {
    pub catalog: &'e Catalog,
    pub open: Open<'e>,
    pub model: Model,
    pub diags: Diags,
    /// Requested files; `None` for one that could not be read, which has been reported.
    pub files: BTreeMap<String, Option<Rc<Home>>>,
    /// Names at the root of the model.
    pub root: BTreeSet<String>,
    /// Size of one instance of a part, by file and name.
    pub sizes: BTreeMap<(String, String), Size>,
    /// True after too many modules.
    pub over: bool,
    /// Parts that are being put in, from the outermost to the innermost: file and name.
    pub open_parts: Vec<(String, String)>,
}

impl Expander<'_> {
    /// Returns true if no more modules are added.
    pub fn is_over(&self) -> bool {
        self.over || self.diags.is_full()
    }

    pub fn too_many(&mut self, at: Span) {
        self.over = true;
        if !self.diags.list.iter().any(|d| d.code == "E027") {
            let d = Diag::error("E027", format!("more than {LARGEST} modules, including modules of parts"))
                .at(at, "limit exceeded here");
            self.diags.push(d.help("use fewer modules; for real time, a few thousand"));
        }
    }
}
