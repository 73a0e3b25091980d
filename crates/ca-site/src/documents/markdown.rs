//! A document as HTML: links lead to the pages of the site, headings have anchors, and whole models can be played.

use super::anchor::Anchors;
use super::{Document, PICTURES, find};
use crate::share;
use ca_compile::Options;
use ca_lab::Loaded;
use pulldown_cmark::{CodeBlockKind, CowStr, Event, LinkType, Options as Syntax, Parser, Tag, TagEnd, html};

/// The content of a page, and the pictures that it shows.
pub(super) struct Rendered {
    pub(super) html: String,
    pub(super) pictures: Vec<(&'static str, &'static [u8])>,
}

/// Renders a document. Links to what is not on the site become plain text, and pictures that are not there are left out.
pub(super) fn rendered(document: &Document) -> Rendered {
    let mut page = Page { document, anchors: Anchors::default(), out: Vec::new(), pictures: Vec::new() };
    let text = for_readers(document.text);
    let mut events = Parser::new_ext(&text, Syntax::ENABLE_TABLES);
    while let Some(event) = events.next() {
        page.take(event, &mut events);
    }
    let mut out = String::new();
    html::push_html(&mut out, page.out.into_iter());
    Rendered { html: out, pictures: page.pictures }
}

/// Returns the text without the sentence that tells the authors of a generated document not to edit it.
fn for_readers(text: &str) -> String {
    let note =
        text.split_once("\nMade by ").and_then(|(before, rest)| Some((before, rest.split_once("do not edit. ")?.1)));
    note.map_or_else(|| text.to_owned(), |(before, after)| format!("{before}\n{after}"))
}

struct Page<'a> {
    document: &'a Document,
    anchors: Anchors,
    out: Vec<Event<'a>>,
    pictures: Vec<(&'static str, &'static [u8])>,
}

impl<'a> Page<'a> {
    /// Takes an event, and from `events` those that belong to it.
    fn take(&mut self, event: Event<'a>, events: &mut Parser<'a>) {
        match event {
            Event::Start(Tag::Heading { level, classes, attrs, .. }) => {
                let inside = until(events, TagEnd::Heading(level));
                let id = Some(self.anchors.next(&plain(&inside)).into());
                self.out.push(Event::Start(Tag::Heading { level, id, classes, attrs }));
                self.inside(inside);
                self.out.push(Event::End(TagEnd::Heading(level)));
            }
            Event::Start(Tag::CodeBlock(kind)) => {
                let inside = until(events, TagEnd::CodeBlock);
                let text = plain(&inside);
                let is_model = matches!(&kind, CodeBlockKind::Fenced(language) if &**language == "toml");
                self.out.push(Event::Start(Tag::CodeBlock(kind)));
                self.out.extend(inside);
                self.out.push(Event::End(TagEnd::CodeBlock));
                if is_model && plays(&text) {
                    let address = format!("{}{}", self.document.root(), share::link(&text));
                    let link = format!("<p class=\"play\"><a href=\"{address}\">Play this</a></p>\n");
                    self.out.push(Event::Html(link.into()));
                }
            }
            Event::Start(Tag::Table(alignments)) => {
                self.out.push(Event::Html("<div class=\"wide\" tabindex=\"0\">".into()));
                self.out.push(Event::Start(Tag::Table(alignments)));
            }
            Event::End(TagEnd::Table) => self.out.extend([Event::End(TagEnd::Table), Event::Html("</div>\n".into())]),
            other => self.inline(other, events),
        }
    }

    /// Takes an event inside a paragraph.
    fn inline(&mut self, event: Event<'a>, events: &mut impl Iterator<Item = Event<'a>>) {
        match event {
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let inside = until(events, TagEnd::Link);
                self.link((link_type, dest_url, title, id), inside);
            }
            Event::Start(Tag::Image { link_type, dest_url, title, id }) => {
                let inside = until(events, TagEnd::Image);
                let name = self.in_docs(&dest_url);
                let Some(picture) = PICTURES.iter().find(|p| Some(p.0) == name.as_deref()) else { return };
                self.pictures.push(*picture);
                self.out.push(Event::Start(Tag::Image { link_type, dest_url, title, id }));
                self.out.extend(inside);
                self.out.push(Event::End(TagEnd::Image));
            }
            // the documents are Markdown alone
            Event::Html(text) | Event::InlineHtml(text) => self.out.push(Event::Text(text)),
            other => self.out.push(other),
        }
    }

    fn inside(&mut self, events: Vec<Event<'a>>) {
        let mut events = events.into_iter();
        while let Some(event) = events.next() {
            self.inline(event, &mut events);
        }
    }

    fn link(&mut self, link: (LinkType, CowStr<'a>, CowStr<'a>, CowStr<'a>), mut inside: Vec<Event<'a>>) {
        let (link_type, dest_url, title, id) = link;
        let target = if dest_url.contains("://") {
            Some((dest_url.to_string(), None))
        } else {
            let (file, anchor) = dest_url.split_once('#').unwrap_or((&dest_url, ""));
            let anchor = if anchor.is_empty() { String::new() } else { format!("#{anchor}") };
            if file.is_empty() {
                Some((anchor, None))
            } else {
                let document = self.in_docs(file).and_then(|name| find(&name));
                document.map(|d| (file.replace("README.md", "index.html").replace(".md", ".html") + &anchor, Some(d)))
            }
        };
        let Some((address, document)) = target else { return self.inside(inside) };
        if let (Some(document), [Event::Text(text)]) = (document, &mut inside[..]) {
            if text.ends_with(".md") {
                *text = document.title().into();
            }
        }
        self.out.push(Event::Start(Tag::Link { link_type, dest_url: address.into(), title, id }));
        self.inside(inside);
        self.out.push(Event::End(TagEnd::Link));
    }

    /// Returns the path in `docs/` of a file that the document names; `None` if it is elsewhere.
    fn in_docs(&self, file: &str) -> Option<String> {
        let mut folders: Vec<&str> = self.document.name.split('/').collect();
        folders.pop();
        for part in file.split('/') {
            if part == ".." {
                folders.pop()?;
            } else {
                folders.push(part);
            }
        }
        Some(folders.join("/"))
    }
}

/// Takes the events up to the end of an element that contains no element of its kind.
fn until<'a>(events: &mut impl Iterator<Item = Event<'a>>, end: TagEnd) -> Vec<Event<'a>> {
    events.take_while(|e| *e != Event::End(end)).collect()
}

/// Returns the text of events without their markup.
fn plain(events: &[Event]) -> String {
    let text = |e: &Event| match e {
        Event::Text(text) | Event::Code(text) => text.to_string(),
        Event::SoftBreak => " ".into(),
        _ => String::new(),
    };
    events.iter().map(text).collect()
}

/// Returns true if a text is a whole model that a page can play: it has a sound output and needs no other file.
fn plays(text: &str) -> bool {
    let loaded = Loaded::read(text, "shared.ca.toml");
    text.lines().any(|l| l.starts_with("[SOX]"))
        && ca_lab::load::needs_no_files(&loaded).is_ok()
        && loaded.compile(&Options::default()).is_ok()
}
