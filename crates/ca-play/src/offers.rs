//! The model as a text, as a link and as one file, which a page can offer beside playing.
//!
//! The program that opens the page knows the site and makes the texts. They may take long, so the thread of the client
//! makes them. The page learns from attributes of its root element what there is.

use crate::asset::PAGE;

/// Names of the text of the model and of the one file, beside the page.
const MODEL: &str = "model.ca.toml";
const ONE_FILE: &str = "instrument.html";

/// Makes a text of the model that a page stored last; `None` before a page has stored one.
pub type MakesText = Box<dyn Fn() -> Option<String> + Send + Sync>;

/// Offers of a page beside playing.
#[derive(Default)]
pub struct Offers {
    /// Address of a site for links to the model.
    pub site: Option<String>,
    /// Makes the text of the model.
    pub model: Option<MakesText>,
    /// Makes one HTML file of the model.
    pub one_file: Option<MakesText>,
}

impl Offers {
    /// Returns the media type and the content of a file that depends on these offers; `None` for any other file.
    pub(crate) fn file(&self, name: &str) -> Option<(&'static str, String)> {
        let html = "text/html; charset=utf-8";
        match name {
            "" | "index.html" => Some((html, self.page())),
            MODEL => Some(("text/plain; charset=utf-8", self.model.as_ref()?()?)),
            ONE_FILE => Some((html, self.one_file.as_ref()?()?)),
            _ => None,
        }
    }

    /// Returns the page with the attributes of these offers.
    fn page(&self) -> String {
        let site = self.site.as_ref().map(|site| format!(" data-site=\"{}\"", escaped(site)));
        let one_file = self.one_file.as_ref().map(|_| format!(" data-one-file=\"{ONE_FILE}\""));
        let root = "<html lang=\"en\"";
        PAGE.replacen(root, &format!("{root}{}{}", site.unwrap_or_default(), one_file.unwrap_or_default()), 1)
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_says_what_it_offers() {
        assert_eq!(Offers::default().page(), PAGE);
        let one_file: Option<MakesText> = Some(Box::new(|| None));
        let page = Offers { site: Some("https://a.example/\"><b>&".into()), model: None, one_file }.page();
        let root = "<html lang=\"en\" data-site=\"https://a.example/&quot;>&lt;b>&amp;\" data-one-file=";
        assert!(page.contains(root), "{page}");
    }
}
