//! The shell of each page of the documents: the head, the link to the instruments and the list of all documents.

use super::{CHAPTERS, Document};
use crate::site::head;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Returns the page of a document.
pub(super) fn page(document: &Document, content: &str) -> String {
    whole(document.title(), &document.root(), Some(document.name), &html! { (PreEscaped(content)) })
}

/// Returns the page that lists all documents with their purposes.
pub(super) fn index() -> String {
    let content = html! {
        h1 { "Documents" }
        @for chapter in CHAPTERS {
            h2 id=(super::anchor(chapter.title)) { (chapter.title) }
            dl {
                @for document in chapter.documents {
                    dt { a href=(document.page()) { (document.title()) } }
                    dd { (document.purpose()) }
                }
            }
        }
    };
    whole("Documents", "../", None, &content)
}

fn whole(title: &str, root: &str, present: Option<&str>, content: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (head(root, &format!("{title} – ca"), "docs.css"))
            }
            body {
                header {
                    a href={ (root) "index.html" } { "Instruments" }
                    a href={ (root) "docs/index.html" } aria-current=[present.is_none().then_some("page")] { "Documents" }
                    a class="down" href="#documents" { "Contents" }
                }
                main { (content) }
                nav id="documents" aria-label="Documents" {
                    @for chapter in CHAPTERS {
                        h2 { (chapter.title) }
                        ul {
                            @for document in chapter.documents {
                                @let here = (present == Some(document.name)).then_some("page");
                                li { a href={ (root) "docs/" (document.page()) } aria-current=[here] { (document.title()) } }
                            }
                        }
                    }
                }
            }
        }
    };
    page.into_string()
}
