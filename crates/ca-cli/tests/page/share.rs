//! Tests what the page gives away: the text of the model as it is now, a link and one file.

use crate::browser::Tab;
use crate::host::{Client, Host, until};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;

/// Stores the model as it is now, and fetches its text.
fn text(host: &Host, page: &mut Client) -> String {
    page.done(&json!({"type": "snapshot"}));
    let (server, path) = host.address.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET /{path}model.ca.toml HTTP/1.1\r\nHost: {server}\r\n\r\n").unwrap();
    let mut all = String::new();
    stream.read_to_string(&mut all).unwrap();
    assert!(all.starts_with("HTTP/1.1 200"), "{all}");
    all.split_once("\r\n\r\n").unwrap().1.to_owned()
}

fn end(mut host: Host) {
    host.page().done(&json!({"type": "stop"}));
    host.ended();
}

/// The text has the moved parameters and the changed numbers, and keeps everything else.
pub fn the_text_is_of_the_model_as_it_is_now() {
    let host = Host::play(crate::STRING, &["--set", "wall.x=1 mm"]);
    let mut page = host.page();
    page.next("scene");
    let set = crate::STRING.replace("wall = {}", "wall = {x = \"1 mm\"}");
    let tidy = |text: &str| text.replace("{ ", "{").replace(" }", "}");
    assert_eq!(tidy(&text(&host, &mut page)), tidy(&set));
    page.done(&json!({"type": "set", "values": {"k": "900 N/m"}}));
    until("it is moved", || page.next("state")["params"]["k"] == 900.0);
    page.done(&json!({"type": "change", "name": "low.t60", "value": "4 s"}));
    until("the new version plays", || page.next("scene")["generation"] == 2);
    let want = set.replace("\"2 kN/m\"", "\"900 N/m\"").replace("t60 = \"3 s\"", "t60 = \"4 s\"");
    assert_eq!(tidy(&text(&host, &mut page)), tidy(&want));
    // it plays
    std::fs::write(host.path("now.ca.toml"), text(&host, &mut page)).unwrap();
    host.ca(&["check", "now.ca.toml"]);
    // a saved version with a part from another file cannot be given away
    std::fs::write(host.path("part.ca.toml"), "[MAS]\nbob = { m = '1 g', dx0 = '1 mm' }\n").unwrap();
    host.write(&format!("{}[use]\na = {{ file = 'part.ca.toml' }}\n", crate::STRING));
    until("it is loaded", || page.next("scene")["generation"] == 3);
    let reply = page.ask(&json!({"type": "snapshot"}));
    assert!(reply["ok"] == false && reply["text"].as_str().unwrap().contains("from other files"), "{reply}");
    end(host);
}

/// The buttons copy a link that carries the text, and save the file that `ca export` writes for this text.
pub fn a_link_is_copied_and_one_file_is_saved() {
    let host = Host::play(crate::STRING, &["--site", "https://example.org/ca"]);
    let Some(mut tab) = Tab::open(&host.address) else { return };
    until("the scene is there", || tab.js("document.getElementById('title').textContent") == "A string and a bob");
    let mut page = host.page();
    page.done(&json!({"type": "set", "values": {"k": "900 N/m"}}));
    until("it is moved", || page.next("state")["params"]["k"] == 900.0);
    let hidden = |tab: &mut Tab, id: &str| tab.js(&format!("document.getElementById('{id}').hidden"));
    assert_eq!([hidden(&mut tab, "sharing"), hidden(&mut tab, "shareLink")], [json!(false), json!(false)]);
    tab.js("window.copied = null; Object.defineProperty(navigator, 'clipboard', \
        {value: {writeText: async t => { window.copied = t; }}}); document.getElementById('shareLink').click()");
    until("the link is copied", || tab.js("window.copied !== null") == true);
    let link = tab.js("window.copied");
    let packed = link.as_str().unwrap().strip_prefix("https://example.org/ca/play.html#model=").unwrap();
    assert!(URL_SAFE_NO_PAD.decode(packed).is_ok(), "{packed}");
    // unpacked by the page of the site itself
    let unpacked = tab.js(&format!("import('./browser/model.js').then(m => m.unpack({}))", json!(packed)));
    let long = tab.js("import('./browser/model.js').then(m => m.pack('#'.repeat(300001))).catch(e => e.message)");
    assert_eq!(long, "The model is too long for a link: at most 300 kB.");
    let now = text(&host, &mut page);
    assert_eq!(unpacked, Value::from(now.clone()));
    assert!(now.contains("900 N/m"), "{now}");
    assert_eq!(hidden(&mut tab, "oneFile"), json!(ca_site::modules().is_none()));
    if ca_site::modules().is_some() {
        tab.js("window.saved = null; const made = URL.createObjectURL; let last; \
            URL.createObjectURL = blob => { last = blob; return made.call(URL, blob); }; \
            HTMLAnchorElement.prototype.click = function () { const name = this.download; \
            last.text().then(text => { window.saved = [name, text]; }); }; document.getElementById('oneFile').click()");
        until("the file is saved", || tab.js("window.saved !== null") == true);
        std::fs::write(host.path("model.ca.toml"), &now).unwrap();
        host.ca(&["export", "model.ca.toml", "--html", "model.html", "--site", "https://example.org/ca"]);
        let want = std::fs::read_to_string(host.path("model.html")).unwrap();
        assert_eq!(tab.js("window.saved[0]"), "model.html");
        assert!(tab.js("window.saved[1]") == *want, "another file");
    }
    assert_eq!(tab.errors(), Vec::<String>::new());
    end(host);

    // links need a site, and the row needs one of both
    let host = Host::play(crate::STRING, &[]);
    let Some(mut tab) = Tab::open(&host.address) else { return };
    until("it is drawn", || tab.js("+document.documentElement.dataset.frames > 5") == true);
    assert_eq!(hidden(&mut tab, "shareLink"), json!(true));
    assert_eq!(hidden(&mut tab, "sharing"), json!(ca_site::modules().is_none()));
    end(host);
}
