//! The site in other browsers: Firefox, and WebKit of GTK. They pass the checks of the page that need no Chromium. Both
//! run on a desktop without a screen and a loudspeaker.

mod desktop;
mod firefox;
mod webkit;

use crate::page::Page;
use crate::page_checks::CHECKS;
use crate::server::Server;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::Child;

/// A process, ended on drop.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

trait Browser: Page {
    /// Opens an address.
    fn go(&mut self, address: &str);

    /// After a failure: returns true if the browser itself stopped, and starts it again.
    fn again(&mut self) -> bool {
        false
    }
}

/// Starts of a browser for a check.
const STARTS: u32 = 10;

/// Runs the checks.
fn checks(site: &Path, server: &Server, page: &mut dyn Browser) {
    std::fs::write(site.join("motion.js"), ca_play::module("motion.js")).unwrap();
    for (n, check) in CHECKS.iter().enumerate() {
        // the service worker keeps files by name
        std::fs::write(site.join(format!("models/checked_{n}.ca.toml")), check.model).unwrap();
        for start in 1..=STARTS {
            let done = catch_unwind(AssertUnwindSafe(|| {
                page.go(&format!("{}play.html?model=checked_{n}", server.address));
                check.in_any(page);
            }));
            match done {
                Err(_) if start < STARTS && page.again() => println!("the browser is started again"),
                Err(why) => resume_unwind(why),
                Ok(()) => break,
            }
        }
    }
}

#[test]
fn firefox_plays_the_site() {
    let Some((modules, _alone)) = crate::built() else { return };
    let Some(desktop) = desktop::Desktop::start() else { return };
    let (dir, server) = crate::folder(modules);
    let Some(mut page) = firefox::Firefox::start(&desktop) else { return };
    checks(dir.path(), &server, &mut page);
}

#[test]
fn webkit_plays_the_site() {
    let Some((modules, _alone)) = crate::built() else { return };
    let Some(desktop) = desktop::Desktop::start() else { return };
    let (dir, server) = crate::folder(modules);
    let Some(mut page) = webkit::WebKit::start(&desktop) else { return };
    checks(dir.path(), &server, &mut page);
}
