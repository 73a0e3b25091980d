//! Measures the latency of the haptic loop: `ca serve` and `ca device sim` as processes, with and without real-time
//! priority, with and without load.
//!
//! The bench uses the summaries of the two commands. They count every frame, and the bench adds no work to the loop. It
//! prints the tables. With `UPDATE=1` it writes them to `docs/measured/latency.md`.
#![allow(missing_docs)]

#[cfg(target_os = "linux")]
mod linux {
    use ca_benches::latency::{Percentiles, RUNS, Run, page};
    use ca_haptic::host::Site;
    use ca_haptic::host::control::{Request, ask};
    use serde_json::Value;
    use std::path::Path;
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    /// A process that is killed on drop.
    struct Proc(Child);

    impl Drop for Proc {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    impl Proc {
        fn ca(site: &Site, args: &[&str]) -> Proc {
            let mut c = Command::new(env!("CARGO_BIN_EXE_ca"));
            c.args(args).env("CA_SHM_ROOT", site.root()).env_remove("CA_CONFIG");
            Proc(c.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("ca starts"))
        }

        fn load() -> Proc {
            let mut c = Command::new(std::env::current_exe().expect("this program"));
            Proc(c.arg("--load").stdin(Stdio::piped()).spawn().expect("load starts"))
        }

        /// Waits for the end and returns the reported JSON.
        fn reported(mut self) -> Value {
            let out = self.0.stdout.take().expect("a pipe");
            let reported = serde_json::from_reader(out).expect("ca tells of its run as JSON");
            self.0.wait().expect("it ends");
            reported
        }
    }

    fn reported(v: &Value) -> Percentiles {
        let us = ["p50", "p99", "p999", "max"].map(|k| v[k].as_f64().unwrap_or(f64::NAN));
        Percentiles { n: v["n"].as_u64().unwrap_or(0), us }
    }

    fn run((priority, load): (bool, bool), seconds: f64) -> Run {
        let dir = tempfile::Builder::new().prefix("cab").tempdir_in("/tmp").expect("a folder");
        let site = Site::at(&dir.path().join("s")).expect("a place");
        let load: Vec<Proc> = (0..if load { 2 } else { 0 }).map(|_| Proc::load()).collect();
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/hammer_piano.ca.toml");
        let [engine, device] = if priority { ["70", "60"] } else { ["0", "0"] };
        let server = Proc::ca(&site, &["serve", model, "--arm", "--json", "--priority", engine]);
        let end = Instant::now() + Duration::from_secs(60);
        while ask(&site, &Request::Status, Duration::from_secs(2)).is_err() {
            assert!(Instant::now() < end, "the server does not answer");
            std::thread::sleep(Duration::from_millis(20));
        }
        let length = seconds.to_string();
        let sim = ["device", "sim", "--profile", "tgr12", "--script", "strike", "--seconds", &length, "--json"];
        let device = Proc::ca(&site, &[&sim[..], &["--priority", device]].concat()).reported();
        ask(&site, &Request::Stop, Duration::from_secs(30)).expect("the server ends");
        let server = server.reported();
        drop(load);
        ca_haptic::host::stale_shm::clean(&site);
        let number = |v: &Value| v.as_u64().unwrap_or(0);
        let granted = server["granted"].as_array().into_iter().flatten().find(|g| g[0] == "engine");
        Run {
            reported: [
                reported(&server["frame_us"]),
                reported(&server["late_us"]),
                reported(&device["loop_us"]),
                reported(&server["devices"][0]["loop_us"]),
            ],
            counts: [
                number(&server["frames"]),
                number(&server["missed"]),
                number(&device["left_out"]),
                number(&server["traffic"]["missed"]),
            ],
            granted: granted.and_then(|g| g[1].as_str()).unwrap_or("unknown").into(),
        }
    }

    pub fn main() {
        if std::env::args().any(|a| a == "--load") {
            std::thread::spawn(|| {
                let _ = std::io::Read::read(&mut std::io::stdin(), &mut [0]);
                std::process::exit(0);
            });
            loop {
                std::hint::spin_loop();
            }
        }
        // `cargo test --benches` only checks that it runs
        let long = std::env::args().any(|a| a == "--bench");
        let seconds = if long { 20.0 } else { 0.2 };
        let runs: Vec<Run> = RUNS.iter().map(|which| run(*which, seconds)).collect();
        let text = page(&runs);
        println!("{text}");
        if long && std::env::var_os("UPDATE").is_some() {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured/latency.md");
            std::fs::write(path, text).expect("the page can be written");
        }
    }
}

fn main() {
    #[cfg(target_os = "linux")]
    linux::main();
}
