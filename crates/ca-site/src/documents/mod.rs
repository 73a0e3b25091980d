//! The documents for players and composers, as pages of the site.
//!
//! They are written in `docs/` as Markdown. The pages keep the folders of the files, so a link between two documents
//! needs only another ending. Documents for developers are not on the site.

mod anchor;
mod markdown;
mod shell;

pub(crate) use anchor::anchor;

use crate::site::File;
use markdown::Rendered;

/// A document, by its path in `docs/`.
pub(crate) struct Document {
    /// Path in `docs/`.
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
}

/// Documents of one purpose.
pub(crate) struct Chapter {
    pub(crate) title: &'static str,
    pub(crate) documents: &'static [Document],
}

macro_rules! chapter {
    ($title:literal $($name:literal)*) => {
        Chapter {
            title: $title,
            documents: &[$(Document { name: $name, text: include_str!(concat!("../../../../docs/", $name)) }),*],
        }
    };
}

pub(crate) const CHAPTERS: &[Chapter] = &[
    chapter!("Make and play" "instrument.md" "play.md" "web.md" "import.md" "fit.md" "sweep.md"),
    chapter!("The language of models" "language/README.md" "language/model.md" "language/numbers.md" "language/groups.md"
        "language/space.md" "language/waveguides.md" "language/stability.md" "language/contacts.md"
        "language/gestures.md" "language/outputs.md" "language/devices.md"),
    chapter!("Force devices" "safety.md" "hand.md"),
    chapter!("Reference" "kinds.md" "commands.md" "glossary.md"),
];

macro_rules! pictures {
    ($($name:literal)*) => { &[$(($name, include_bytes!(concat!("../../../../docs/", $name)))),*] };
}

/// Pictures of the documents, by their paths in `docs/`.
const PICTURES: &[(&str, &[u8])] = pictures!("pictures/hammer_piano.webp" "pictures/hammered_string.webp"
    "pictures/membrane.webp" "pictures/plucked_string.webp");

/// Returns the document with a path in `docs/`.
fn find(name: &str) -> Option<&'static Document> {
    CHAPTERS.iter().flat_map(|c| c.documents).find(|d| d.name == name)
}

impl Document {
    /// Returns the path of the page in the folder `docs` of the site.
    fn page(&self) -> String {
        self.name.replace("README.md", "index.html").replace(".md", ".html")
    }

    /// Returns the way from the folder of the page to the folder of the site.
    fn root(&self) -> String {
        "../".repeat(1 + self.name.matches('/').count())
    }

    fn title(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches("# ")
    }

    /// Returns what a reader can do after this page, as a sentence.
    fn purpose(&self) -> String {
        let paragraph: Vec<&str> = self.text.lines().skip(2).take_while(|l| !l.is_empty()).collect();
        let paragraph = paragraph.join(" ").replace('`', "");
        let sentence = paragraph.split(". ").next().unwrap_or_default().trim_end_matches('.');
        let purpose = sentence.trim_start_matches("After this page you can ");
        let mut letters = purpose.chars();
        letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect::<String>() + ".")
    }
}

/// Returns the pages of all documents, their index and their pictures.
pub(crate) fn files() -> Vec<File> {
    let mut files: Vec<File> = vec![("docs/index.html".into(), shell::index().into_bytes())];
    for document in CHAPTERS.iter().flat_map(|c| c.documents) {
        let Rendered { html, pictures } = markdown::rendered(document);
        files.push((format!("docs/{}", document.page()), shell::page(document, &html).into_bytes()));
        for (name, bytes) in pictures {
            let file = (format!("docs/{name}"), bytes.to_vec());
            if !files.contains(&file) {
                files.push(file);
            }
        }
    }
    files
}
