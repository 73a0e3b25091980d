//! Devices and servers in processes of their own, which are killed, stopped, started again.

use crate::desk::{Server, spawn};
use ca_haptic::host::Site;

#[path = "../../examples/device.rs"]
mod example;

/// What a second process does; nothing in the first.
#[test]
fn role() {
    let Ok(role) = std::env::var("CA_TEST_ROLE") else { return };
    let args = std::env::var("CA_TEST_ARGS").unwrap_or_default();
    match role.as_str() {
        "device" => {
            let (name, frames) = args.split_once(' ').unwrap();
            println!("{}", example::run(name, frames.parse().unwrap()).unwrap());
        }
        "server" => {
            let names: Vec<_> = args.split(' ').collect();
            let mut server = Server::open(&Site::of_user().unwrap(), &names, u64::from(std::process::id()));
            println!("open");
            loop {
                server.serve();
                std::thread::sleep(std::time::Duration::from_micros(100));
            }
        }
        other => panic!("no role `{other}`"),
    }
}

#[test]
fn the_example_plays() {
    let place = crate::desk::place();
    let mut child = spawn(&place.site, "device", "finger 500");
    let mut server = Server::open(&place.site, &["finger"], 3);
    crate::desk::until("it ends", || {
        server.serve();
        child.try_wait().unwrap().is_some()
    });
    let out = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success() && said.contains("sent 500") && said.contains("mode on"), "{said}");
}
