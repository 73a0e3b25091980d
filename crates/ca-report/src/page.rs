//! Writes the page: head, contents, sections, and the data of the plots.
//!
//! Text of a model cannot become markup. `maud` escapes it, and the data in the script element have every `<` as a JSON
//! escape, so that no text ends the element. Only the style and the scripts of this crate are not escaped.

use crate::plot::Plot;
use crate::report::{Block, Picture, Report, Section, Table, Weight};
use crate::sound::Sound;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Value as Json, json};

const STYLE: &str = include_str!("../assets/report.css");
/// Scripts in the order of their dependencies.
const SCRIPTS: [&str; 3] =
    [include_str!("../assets/axis.js"), include_str!("../assets/plot.js"), include_str!("../assets/report.js")];
/// Policy that forbids loading anything outside this file.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                      media-src data:; base-uri 'none'; form-action 'none'";

fn data_uri(media: &str, bytes: &[u8]) -> String {
    format!("data:{media};base64,{}", STANDARD.encode(bytes))
}

/// Formats a number with four digits.
fn digits(v: f64) -> String {
    if v == 0.0 {
        return "0".into();
    }
    let places = 3 - v.abs().log10().floor() as i32;
    if (0..=6).contains(&places) { format!("{v:.*}", places as usize) } else { format!("{v:.3e}") }
}

/// Formats a text with names in backquotes.
fn words(text: &str) -> Markup {
    if text.matches('`').count() % 2 == 1 {
        return html! { (text) };
    }
    html! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

impl Report {
    /// Returns the page.
    pub fn html(&self) -> String {
        page(self)
    }
}

fn page(report: &Report) -> String {
    let mut plots: Vec<Json> = Vec::new();
    let sections: Vec<Markup> = report.sections.iter().enumerate().map(|(i, s)| section(i, s, &mut plots)).collect();
    let film = report.picture.as_ref().map(|p| {
        let mut about = p.about.clone();
        about["bytes"] = STANDARD.encode(&p.bytes).into();
        about
    });
    let data = json!({ "plots": plots, "film": film }).to_string().replace('<', "\\u003c");
    let whole = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="generator" content={ "ca " (env!("CARGO_PKG_VERSION")) };
                link rel="icon" href="data:,";
                title { (report.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (report.title) }
                    p.subtitle { (words(&report.subtitle)) }
                }
                nav aria-label="Contents" {
                    @for (i, s) in report.sections.iter().enumerate() {
                        a href={ "#s" (i) } { (s.title) }
                    }
                }
                main {
                    @if let Some(picture) = &report.picture { (film_box(picture)) }
                    @for (weight, text) in &report.notes {
                        p.note.warning[*weight == Weight::Warning] role="note" { (words(text)) }
                    }
                    noscript {
                        p.note { "Plots need JavaScript, which is turned off: turn it on and reload the page. Everything else is shown." }
                    }
                    @for s in sections { (s) }
                }
                footer {
                    p { "This page is a single file and needs no network. Drag in a plot to zoom; double-click to reset. Click in a plot over time to move the sound to that time." }
                }
                script type="application/json" id="data" { (PreEscaped(data)) }
                @for script in SCRIPTS { script { (PreEscaped(script)) } }
                @if let Some(picture) = &report.picture { script { (PreEscaped(&picture.script)) } }
            }
        }
    };
    whole.into_string()
}

/// Writes the moving instrument, synchronised with the first player.
fn film_box(picture: &Picture) -> Markup {
    html! {
        figure id="film" {
            canvas id="filmCanvas" tabindex="0" role="img" aria-label="The moving instrument" {}
            div.film {
                button id="filmPlay" type="button" { "Play" }
                input id="filmAt" type="range" min="0" max="1" step="any" value="0" aria-label="Time";
                output id="filmTime" { "0.00 s" }
            }
            @if !picture.note.is_empty() { p.told { (words(&picture.note)) } }
        }
    }
}

fn section(i: usize, s: &Section, plots: &mut Vec<Json>) -> Markup {
    html! {
        section id={ "s" (i) } {
            h2 { (s.title) }
            @for block in &s.blocks {
                @match block {
                    Block::Text(text) => p { (words(text)) },
                    Block::Sound(sound) => (players(sound)),
                    Block::Plot(plot) => (figure(plot, plots)),
                    Block::Table(table) => (rows(table)),
                    Block::Source(name, text) => details open[text.lines().count() <= 120] {
                        summary { code { (name) } ", " (text.lines().count()) " lines" }
                        pre.source { code { (text) } }
                    },
                }
            }
        }
    }
}

fn players(sound: &Sound) -> Markup {
    html! {
        div.players {
            @for (name, wav) in sound.players() {
                div {
                    audio controls preload="auto" src=(data_uri("audio/wav", &wav)) {}
                    span { (name) }
                }
            }
        }
        @if sound.held() < sound.seconds() {
            p.note { "The players contain the first " (digits(sound.held())) " s of " (digits(sound.seconds())) " s." }
        }
    }
}

fn figure(plot: &Plot, plots: &mut Vec<Json>) -> Markup {
    if plot.is_empty() {
        return html! { p { (plot.title) ": no data." } };
    }
    let id = format!("p{}", plots.len());
    plots.push(plot.json(&id));
    let (unit, ranges) = plot.ranges();
    let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    html! {
        figure {
            figcaption { (plot.title) }
            div.plot id=(id) role="img" aria-label=(plot.title) {
                @if let Some(image) = &plot.image {
                    img id={ (id) "-image" } src=(data_uri("image/png", &image.png)) alt=(plot.title);
                }
            }
            @if let Some(image) = &plot.image {
                div.key {
                    span { (image.key.0) }
                    span.bar style={ "background:linear-gradient(to right," (image.key.2.join(",")) ")" } {}
                    span { (image.key.1) }
                }
            } @else {
                details {
                    summary { "Numbers" }
                    div.scroll { table {
                        thead { tr {
                            th { (plot.y.label) (unit) } th.number { "minimum" } th.number { "maximum" } th.number { "last" }
                        } }
                        tbody { @for (name, extent) in ranges { tr {
                            td { (name) }
                            @match extent {
                                Some(e) => { @for v in e { td.number { (digits(v)) } } }
                                None => td.number colspan="3" { "no data" },
                            }
                        } } }
                    } }
                }
            }
        }
    }
}

/// Returns true for a column of numbers: most of its cells begin like one.
fn is_number(table: &Table, column: usize) -> bool {
    let begins = |c: &String| c.starts_with(|c: char| c.is_ascii_digit() || "+-∞".contains(c));
    let numbers = table.rows.iter().filter(|r| r.get(column).is_some_and(begins)).count();
    !table.head.is_empty() && 2 * numbers > table.rows.len()
}

fn rows(table: &Table) -> Markup {
    let width = table.rows.iter().map(Vec::len).max().unwrap_or(0);
    let number: Vec<bool> = (0..width).map(|i| is_number(table, i)).collect();
    let right = |i: usize| number.get(i) == Some(&true);
    html! {
        div.scroll { table {
            @if !table.head.is_empty() {
                thead { tr { @for (i, h) in table.head.iter().enumerate() { th.number[right(i)] { (h) } } } }
            }
            tbody { @for row in &table.rows { tr {
                @for (i, cell) in row.iter().enumerate() {
                    @if i == 0 { th.number[right(i)] scope="row" { (words(cell)) } }
                    @else { td.number[right(i)] { (words(cell)) } }
                }
            } } }
        } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Axis, Curve, Grid, Mark};

    /// Texts that end an element, an attribute or a text, at every place where a model can put text.
    #[test]
    fn no_text_becomes_markup() {
        const EVIL: &str = "</script><script>alert(1)</script>\"'><img src=x onerror=alert(1)>&amp;<!--]]>";
        let mut report = Report::new(EVIL, EVIL);
        report.notes.push((Weight::Warning, EVIL.into()));
        let mut sound = Sound::new(8000.0, &[EVIL.into()]);
        sound.push(&[0.0, 0.5]);
        let mut plot = Plot::over_time(
            EVIL,
            Axis::linear(EVIL, EVIL),
            Grid::Even { start: 0.0, step: 1.0, n: 2 },
            vec![Curve::line(EVIL, vec![1.0, 2.0])],
        );
        plot.marks.push(Mark { x: 0.5, y: None, text: EVIL.into() });
        let table = Table::new(&[EVIL], vec![vec![EVIL.into()]]);
        let blocks = vec![
            Block::Text(EVIL.into()),
            Block::Sound(sound),
            Block::Plot(plot),
            Block::Table(table),
            Block::Source(EVIL.into(), EVIL.into()),
        ];
        report.sections.push(Section::new(EVIL, blocks));
        let page = report.html();
        assert!(!page.contains("alert(1)</script>") && !page.contains("<img src=x") && !page.contains("<!--]]"));
        assert_eq!(page.matches("</script>").count(), 4, "data, axis, plot, report");
        assert_eq!(page.matches("<script").count(), 4);
        let shown = "&lt;/script&gt;&lt;script&gt;alert(1)";
        // title, h1, subtitle, contents, note, h2, text, player, caption, aria-label, label and unit of an axis,
        // curve, table twice, source twice
        assert_eq!(page.matches(shown).count(), 17);
        // the data contain the text unchanged
        let (_, data) = page.split_once("id=\"data\">").unwrap();
        let data: Json = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
        let p = &data["plots"][0];
        for word in [&p["y"]["label"], &p["y"]["unit"], &p["curves"][0]["name"], &p["marks"][0][2]] {
            assert_eq!(word, EVIL);
        }
    }

    /// Size of a page without sound and plots, which is its style and scripts.
    #[test]
    fn an_empty_page_is_light_and_asks_for_nothing() {
        let page = Report::new("t", "s").html();
        assert!(page.len() < 30_000, "{} bytes", page.len());
        assert!(page.contains("default-src 'none'"));
        assert_eq!(page.matches("http").count(), 1, "`http-equiv` alone");
        for word in ["<link rel=\"stylesheet\"", "@import", "url(", "fetch(", "XMLHttp", "import("] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
