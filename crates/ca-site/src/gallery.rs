//! The gallery: a card for each bundled instrument.

use crate::picture::svg;
use ca_compile::Options;
use ca_lab::load::{self, BUNDLED};
use ca_lab::{Failure, Loaded};
use ca_view::Drawing;
use maud::{DOCTYPE, PreEscaped, html};

/// Most masses in a picture of the gallery.
const MASSES: usize = 400;

/// A card.
struct Card {
    name: &'static str,
    title: String,
    text: String,
    picture: String,
}

/// Returns the page of the gallery.
///
/// # Errors
/// If a bundled model does not compile.
pub fn gallery() -> Result<String, Failure> {
    let cards = BUNDLED.iter().map(|(name, text)| card(name, text)).collect::<Result<Vec<_>, _>>()?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (super::site::head("", "ca: instruments you can touch", "gallery.css"))
                link rel="manifest" href="site.webmanifest";
            }
            body {
                header {
                    h1 { "Instruments you can touch" }
                    p { "Each one is made of masses and links between them. One physical model makes the sound and the picture. Choose one, press Play, then pull at it." }
                    p class="ways" {
                        a href="play.html?model=blank" { "Start from a short model" }
                        a href="docs/index.html" { "Documents" }
                    }
                }
                main {
                    @for card in &cards {
                        a class="card" href={ "play.html?model=" (card.name) } {
                            (PreEscaped(&card.picture))
                            h2 { (card.title) }
                            p { (card.text) }
                        }
                    }
                }
            }
        }
    };
    Ok(page.into_string())
}

fn card(name: &'static str, text: &str) -> Result<Card, Failure> {
    let loaded = Loaded::read(text, &format!("{name}.ca.toml"));
    let scene = loaded.compile(&Options::default())?.scene;
    let title = loaded.model.title().to_string();
    // the first sentence of the header, without the name and how to play
    let header = loaded.model.header.split("Play:").next().unwrap_or_default();
    let header = header.split_once(": ").map_or(header, |h| h.1);
    let first = header.split(['.', ';']).next().unwrap_or_default().trim();
    let mut letters = first.chars();
    let text = letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect::<String>() + ".");
    Ok(Card { name, title, text, picture: svg(&Drawing::of_at_most(&scene, MASSES)) })
}

/// Texts of the bundled models, by name.
pub fn texts() -> impl Iterator<Item = (&'static str, &'static str)> {
    BUNDLED.iter().map(|(name, text)| (*name, *text))
}

/// Text of the model that a page without a choice begins with.
pub fn blank() -> &'static str {
    load::STARTER
}
