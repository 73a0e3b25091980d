//! The page of `ca play`: a moving instrument in a browser, and the server on this machine that feeds it.
//!
//! [`Page`] carries the messages of [`ca_session::protocol`] and knows neither scene nor engine: the program gives it a
//! greeting, pictures, sound and news, and answers requests. [`Keep`] writes the files that a page asks for. Not a web server for anything else: it speaks to this machine alone, has
//! no file but those of the page, and whoever does not know the token of this run gets nothing (`http.rs`).
//!
//! The page itself is `page/`: plain HTML, CSS and modules of JavaScript, without anybody else's code and without a build.
#![forbid(unsafe_code)]

mod asset;
mod client;
mod film;
mod http;
mod keep;
mod page;
mod pending;

pub use film::script as film_script;
pub use keep::{Keep, TapeSink};
pub use page::{Feed, Page, PageRequest};
