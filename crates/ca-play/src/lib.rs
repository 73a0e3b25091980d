//! Page of `ca play`: a moving instrument in a browser, and the local server behind it.
//!
//! [`Page`] transmits the messages of [`ca_session::protocol`] and knows neither scene nor engine. The program supplies
//! the greeting, pictures, sound and messages, and answers requests. [`PageFiles`] writes the files that a page requests.
//! The server listens only on this machine and serves only the files of the page, and the model as a text or one file ([`Offers`]). It refuses requests without the token
//! of this run (`http.rs`).
//!
//! The page itself is in `page/`: plain HTML, CSS and JavaScript modules, without third-party code and without a build
//! step.
#![forbid(unsafe_code)]

mod asset;
mod bundle;
mod client;
mod http;
mod offers;
mod page;
mod page_files;
mod pending;

pub use asset::{PAGE, STYLE, module};
pub use bundle::bundle;
pub use offers::{MakesText, Offers};
pub use page::{Feed, Page, PageRequest};
pub use page_files::{PageFiles, SoundFileSink};
