//! Tests `ca report`: the contents of the page, and that a browser draws it without a network request.

use crate::sandbox::{BAR, KEY, STRUCK, Sandbox};
use crate::session::take::performer;
use crate::skipped::skipped;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value as Json;
use std::fs;
use std::process::Command;

/// A written page: its text and the data of its plots.
struct Page {
    html: String,
    plots: Vec<Json>,
}

impl Page {
    fn of(sandbox: &Sandbox, name: &str) -> Page {
        let html = fs::read_to_string(sandbox.path(name)).unwrap();
        let (_, data) = html.split_once("id=\"data\">").unwrap();
        let data: Json = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
        let plots = data["plots"].as_array().unwrap().clone();
        Page { html, plots }
    }

    #[track_caller]
    fn says(&self, words: &[&str]) -> &Page {
        for w in words {
            assert!(self.html.contains(w), "no `{w}` on the page");
        }
        self
    }

    fn titles(&self) -> Vec<&str> {
        self.html.split("<h2>").skip(1).map(|rest| rest.split("</h2>").next().unwrap()).collect()
    }

    /// Plot whose vertical axis has this label.
    #[track_caller]
    fn plot(&self, label: &str) -> &Json {
        self.plots.iter().find(|p| p["y"]["label"] == label).unwrap_or_else(|| panic!("no plot of {label}"))
    }

    /// Size of the page without sound, in bytes.
    fn weight(&self) -> usize {
        let sounds = self.html.split("data:audio/wav;base64,").skip(1);
        self.html.len() - sounds.map(|s| s.split('"').next().unwrap().len()).sum::<usize>()
    }
}

fn names(plot: &Json) -> Vec<&str> {
    plot["curves"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect()
}

#[test]
fn a_model_is_reported_whole() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK).put("key.csv", KEY);
    let r = sandbox.ca(&["report", "struck.ca.toml", "--accuracy", "0.05"]).is(0).says(&[
        "struck.html",
        "kB",
        "sound, motion, energy",
    ]);
    assert_eq!(r.err, "");
    let page = Page::of(&sandbox, "struck.html");
    assert_eq!(
        page.titles(),
        ["Summary", "Sound", "Motion", "Energy", "Modes", "Error against run time", "Stability", "Model"]
    );
    page.says(&["rule of thumb", "The ledger balances to", "45 MAT", "Peak: ", "data:image/png;base64,"]);
    page.says(&["[STRING]", "real-time factor"]);
    // length of the model, 16 bits, two channels
    let wav = page.html.split("data:audio/wav;base64,").nth(1).unwrap().split('"').next().unwrap();
    assert_eq!(wav.len().div_ceil(4), (4 * 48_000 * 4 + 44_usize).div_ceil(3));
    assert_eq!(names(page.plot("sample")), ["left", "right"]);
    // the modules measured by outputs, named as in the model, and the key
    let motion = names(page.plot("displacement"));
    assert!(motion.contains(&"key") && motion.len() == 3, "{motion:?}");
    assert!(names(page.plot("energy")).starts_with(&["stored", "stored, kinetic", "lost"]));
    assert!(page.weight() < 300_000, "{} bytes beside the sound", page.weight());
    // the first modes are marked at the frequencies that are heard
    let j = sandbox.ca(&["modes", "struck.ca.toml", "--json"]).is(0).json();
    let marks = page.plot("level of a sine")["marks"].as_array().unwrap();
    assert!(marks.len() > 20, "{}", marks.len());
    for mark in marks {
        let number: usize = mark[2].as_str().unwrap().parse().unwrap();
        let mode = &j["modes"][number - 1];
        assert_eq!(mark[0], mode["heard_hz"]);
        // the hammer on its shank also oscillates but is not heard
        assert!(["left", "right"].iter().any(|o| mode["ports"][o].as_f64().unwrap().abs() > 0.0), "{mode}");
    }
    assert!((marks[0][0].as_f64().unwrap() - 110.0).abs() < 0.01, "the string begins at its pitch");

    let more = ["--probe", "strike", "--probe", "low[3]", "--gesture", "key.csv", "--seconds", "500 ms", "-q"];
    let args =
        [&["report", "struck.ca.toml", "-o", "b.html", "--set", "low.n=20", "--set", "right.gain=1000"][..], &more]
            .concat();
    assert_eq!(sandbox.ca(&args).is(0).out, "");
    let page = Page::of(&sandbox, "b.html");
    assert_eq!((names(page.plot("displacement")), names(page.plot("force"))), (vec!["low[3]"], vec!["strike"]));
    page.says(&["low.n = 20", "0.5 s"]);
    sandbox.ca(&["report", "struck.ca.toml", "--probe", "lowe"]).is(1).says(&["`lowe`"]);
}

#[test]
fn the_energy_on_the_page_is_that_of_the_render() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    sandbox.ca(&["report", "bar.ca.toml"]).is(0);
    let j = sandbox.ca(&["render", "bar.ca.toml", "--energy", "--json"]).is(0).json();
    let held = j["energy"]["at_load"].as_f64().unwrap();
    // one cell of 1 g at 220 Hz, displaced by 1 mm: ½kx², up to the k of the scheme
    let omega = std::f64::consts::TAU * 220.0;
    let want = 0.5 * 1e-3 * omega * omega * 1e-6;
    assert!((held / want - 1.0).abs() < 2e-3, "{held} J, by hand {want} J");
    let cell = format!(">{held:.2e} J</td>");
    Page::of(&sandbox, "bar.html").says(&[&cell]);
}

/// Covers silent, mute, short, diverging and clipped sounds. Each page reports its problem.
#[test]
fn what_is_odd_still_has_a_page() {
    let sandbox = Sandbox::new();
    let quiet = BAR.replace(", dx0 = \"1 mm\"", "");
    sandbox.put("bar.ca.toml", BAR).put("quiet.ca.toml", &quiet);
    sandbox.put("mute.ca.toml", "[CEL]\nbar = { m = 1, f = 9, dx0 = 1 }\n");
    sandbox.put("empty.ca.toml", "[SOL]\nwall = {}\n[SOX]\nout = { from = \"wall\" }\n");
    let wild = "[SOL]\nwall = {}\n[MAS]\nbob = { m = \"1 g\", dx0 = \"1 mm\" }\n[REF]\nspring = { between = [\"wall\", \
                \"bob\"], k = \"20 MN/m\", z = \"1 mN s/m\" }\n[SOX]\nout = { from = \"bob\", gain = 100 }\n";
    sandbox.put("wild.ca.toml", wild);
    sandbox.ca(&["report", "quiet.ca.toml"]).is(0).says(&["all outputs are silent"]);
    Page::of(&sandbox, "quiet.html").says(&["all outputs are silent", "silent", "Nothing moved"]);
    sandbox.ca(&["report", "mute.ca.toml", "--seconds", "1"]).is(0).says(&["no output"]);
    assert_eq!(Page::of(&sandbox, "mute.html").titles(), ["Summary", "Energy", "Modes", "Stability", "Model"]);
    sandbox.ca(&["report", "empty.ca.toml"]).is(0);
    Page::of(&sandbox, "empty.html").says(&["has no moving masses"]);
    sandbox.ca(&["report", "wild.ca.toml", "--seconds", "100 ms"]).is(3).says(&["diverged", "`bob`"]);
    Page::of(&sandbox, "wild.html").says(&["class=\"note warning\"", "diverged", "unstable", "A mode grows"]);
    sandbox.ca(&["report", "bar.ca.toml", "-o", "one.html", "--seconds", "20 us"]).is(0);
    assert_eq!(Page::of(&sandbox, "one.html").plot("sample")["grid"][2], 1);
    // the reference rate for this sound rate would be too high
    sandbox.ca(&["report", "bar.ca.toml", "-o", "fast.html", "--rate", "400 kHz", "--seconds", "2 ms"]).is(0);
    Page::of(&sandbox, "fast.html").says(&["is above the limit of 1e7 Hz"]);
    sandbox.ca(&["report", "bar.ca.toml", "-o", "loud.html", "--set", "loud=5000"]).is(3).says(&["beyond full scale"]);
    Page::of(&sandbox, "loud.html").says(&["multiply the gain"]);
    browse(&sandbox, &["quiet.html", "mute.html", "empty.html", "wild.html", "one.html", "loud.html"]);
}

/// An output is drawn on the axis of the quantity it measures: a coil measures speed, not displacement.
#[test]
fn what_outputs_hear_is_drawn_in_its_unit() {
    let sandbox = Sandbox::new();
    let all = ["position", "speed", "acceleration", "force"];
    let outputs = all.map(|hear| format!("{hear} = {{ from = \"{hear}_ball\", hear = \"{hear}\" }}\n")).concat();
    let balls = all.map(|hear| format!("{hear}_ball = {{ m = \"1 g\", dx0 = \"1 mm\" }}\n")).concat();
    let springs = all
        .map(|hear| format!("{hear}_spring = {{ between = [\"wall\", \"{hear}_ball\"], k = \"1 kN/m\" }}\n"))
        .concat();
    sandbox.put("balls.ca.toml", &format!("[SOL]\nwall = {{}}\n[MAS]\n{balls}[RES]\n{springs}[SOX]\n{outputs}"));
    sandbox.ca(&["report", "balls.ca.toml", "--seconds", "0.1", "--accuracy", "0"]);
    let page = Page::of(&sandbox, "balls.html");
    // 1 mm at √(k/m) = 1000/s, in the units of the page
    for (quantity, hear, peak, unit) in [
        ("displacement", "position", 1.0, "mm"),
        ("speed", "speed", 1.0, "m/s"),
        ("acceleration", "acceleration", 1000.0, "m/s²"),
        ("force", "force", 1.0, "N"),
    ] {
        let plot = page.plot(quantity);
        assert_eq!((names(plot), plot["y"]["unit"].as_str().unwrap()), (vec![&*format!("{hear}_ball")], unit));
        let y = STANDARD.decode(plot["curves"][0]["y"].as_str().unwrap()).unwrap();
        let most = y.as_chunks::<4>().0.iter().fold(0.0, |m: f32, v| m.max(f32::from_le_bytes(*v).abs()));
        assert!((most / peak - 1.0).abs() < 1e-3, "{quantity}: {most}, not {peak}");
    }
}

/// An output of a force may measure every mode, so no mode is called silent and all are marked.
#[test]
fn modes_are_not_silent_to_who_hears_forces() {
    let sandbox = Sandbox::new();
    let plain = "[ENF]\npush = { to = \"g[3]\" }\n[STRING]\ng = { n = 20, f = \"110 Hz\", m = \"10 g\", t60 = \"2 s\" }\n[SOF]\nout = { from = \"g.link[0]\" }\n[gesture]\npush = [[0, 1], [0.01, 0]]\n";
    sandbox.put("force.ca.toml", plain).put("both.ca.toml", &format!("{plain}[SOX]\nnear = {{ from = \"g[9]\" }}\n"));
    for (name, levels) in [("force", false), ("both", true)] {
        sandbox.ca(&["report", &format!("{name}.ca.toml"), "--seconds", "1", "--accuracy", "0"]);
        let page = Page::of(&sandbox, &format!("{name}.html"));
        page.says(&["These outputs do not measure displacement"]);
        for lie in ["silent", "not audible"] {
            assert!(!page.html.contains(&format!(">{lie}<")), "{name}: `{lie}` on the page");
        }
        assert_eq!(page.html.contains("at the displacement outputs [dB]"), levels, "{name}");
        assert!(!page.html.contains(">at the outputs [dB]<"), "{name}");
        assert!(!names(page.plot("T60")).contains(&"not audible"), "{name}");
        let marks = page.plot("level of a sine")["marks"].as_array().unwrap();
        assert!(marks.len() >= 20, "{name}: {} modes are marked", marks.len());
    }
}

/// The reported energy of a diverged model is not the size of the divergence.
#[test]
fn the_energy_of_a_divergence_is_no_number() {
    let sandbox = Sandbox::new();
    for k in ["9.3 MN/m", "11 MN/m"] {
        let wild = format!(
            "[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = \"1 g\", dx0 = \"1 mm\" }}\n[RES]\nspring = {{ between = [\"wall\", \"bob\"], k = \"{k}\" }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
        );
        sandbox.put("wild.ca.toml", &wild);
        for more in [&["--energy"][..], &[]] {
            let r = sandbox.ca(&[&["render", "wild.ca.toml", "--seconds", "1"], more].concat()).is(3);
            assert!(r.out.contains("energy     out of range") && !r.out.contains("peak,"), "{}", r.out);
            assert!(!r.out.contains("stored") && r.out.contains("although no energy is created"), "{}", r.out);
        }
        sandbox.ca(&["report", "wild.ca.toml", "--accuracy", "0", "--seconds", "1"]).is(3);
        let page = Page::of(&sandbox, "wild.html");
        page.says(&["although no energy is created"]);
        assert!(!page.html.contains("The ledger balances"), "{k}");
        let energies: Vec<&Json> = page.plots.iter().filter(|p| p["y"]["label"] == "energy").collect();
        assert!(energies.iter().all(|p| p["y"]["unit"] != "GJ"), "{k}: {energies:?}");
    }
}

/// Titles, file names and comments remain text, whatever they contain.
#[test]
fn no_word_of_a_model_becomes_markup() {
    let sandbox = Sandbox::new();
    let evil = "</title></script><script>document.title = 'mine'</script><img src='http://127.0.0.1:9/x'>";
    let model = BAR.replace("One bar", evil).replace("[param]", &format!("# {evil}\n[param]"));
    sandbox.put("bad & <b>.ca.toml", &model);
    sandbox.ca(&["report", "bad & <b>.ca.toml", "-o", "e.html"]).is(0);
    let page = Page::of(&sandbox, "e.html");
    page.says(&["bad &amp; &lt;b&gt;.ca.toml", "&lt;/title&gt;"]);
    assert_eq!((page.html.matches("<script").count(), page.html.matches("<img src='").count()), (5, 0));
    browse(&sandbox, &["e.html"]);
}

#[test]
fn a_take_is_reported_as_it_was() {
    let sandbox = Sandbox::new();
    let p = performer::duo(&sandbox.path("take.mcap"), 2500);
    sandbox.ca(&["report", "take.mcap"]).is(0).says(&["take.html", "SOFTWARE"]);
    let page = Page::of(&sandbox, "take.html");
    let titles = page.titles();
    for title in ["Sound", "Hand at left", "Hand at right", "Events", "Real time", "Energy", "Stability", "Model"] {
        assert!(titles.contains(&title), "no {title} in {titles:?}");
    }
    page.says(&[
        "bit-identical: 5000 force frames",
        "tripped: SOFTWARE",
        "stiff = 731",
        "reset to the state at load",
        "bar.f",
    ]);
    assert_eq!((names(page.plot("position")), names(page.plot("force"))), (vec!["key"], vec!["key"]));
    assert_eq!(page.plot("force")["marks"][0][2], "SOFTWARE");
    assert!(page.weight() < 300_000, "{} bytes beside the sound", page.weight());
    // every gesture frame is included in order: the last point is at the end of the take
    let grid: Vec<f64> = serde_json::from_value(page.plot("position")["grid"].clone()).unwrap();
    let end = grid[0] + grid[1] * (grid[2] - 1.0);
    let seconds = p.engine.due() as f64 / 48_000.0;
    assert!((end - seconds).abs() < 4.0 * grid[1], "{end} s of {seconds} s");

    for args in [&["--set", "bar.f=1"][..], &["--seconds", "1"], &["--probe", "bar"], &["--rate", "44100"]] {
        sandbox.ca(&[&["report", "take.mcap"], args].concat()).is(2).says(&["as it was played"]);
    }
    let bytes = fs::read(sandbox.path("take.mcap")).unwrap();
    fs::write(sandbox.path("cut.mcap"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    sandbox.ca(&["report", "cut.mcap"]).is(3).says(&["cut off"]);
    Page::of(&sandbox, "cut.html").says(&["the file was cut off"]);
    sandbox.put("no.mcap", "nothing");
    sandbox.ca(&["report", "no.mcap"]).is(1);
    browse(&sandbox, &["take.html", "cut.html"]);
}

#[test]
fn a_real_loop_has_its_times_on_the_page() {
    let sandbox = Sandbox::new();
    let line =
        "ca device sim --profile tgr12 --seconds 3 > sim.txt 2>&1 & ca serve piano_key --seconds 1 --arm --log t.mcap";
    let served = sandbox.sh(&format!("{line}; wait"));
    // lost frames on a slow machine do not matter here
    assert!(served.code == 0 || served.code == 3, "{}", served.err);
    let r = sandbox.ca(&["report", "t.mcap"]);
    assert!(r.code == 0 || r.code == 3, "{}", r.err);
    let page = Page::of(&sandbox, "t.html");
    page.says(&["Time between device frames", "Loop time from hand to force to hand", "99.9 %", "missed"]);
    browse(&sandbox, &["t.html"]);
}

#[test]
fn a_page_is_drawn_without_a_request() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox.ca(&["report", "struck.ca.toml", "-o", "a.html", "--probe", "strike", "--probe", "low[3]"]).is(0);
    browse(&sandbox, &["a.html"]);
    // checks that the counters of the page detect a broken page
    let broken = fs::read_to_string(sandbox.path("a.html"))
        .unwrap()
        .replace("const players", "fetch('http://127.0.0.1:9');undefined.x;const players");
    sandbox.put("broken.html", &broken);
    if let Some(dom) = dom(&sandbox, "broken.html") {
        assert!(!dom.contains("data-errors=\"0\""), "an error is counted");
        assert!(!dom.contains("data-violations=\"0\""), "a request is refused and counted");
    }
}

/// Ticks of a logarithmic axis over few decades are 1, 2 and 5 of each decade; other ticks are multiples of such a
/// step. All have labels.
#[test]
fn a_tick_says_what_it_stands_for() {
    let sandbox = Sandbox::new();
    let script = include_str!("../../../../ca-report/assets/axis.js");
    let ticks = "const ticks = (log, low, high) => { const a = new Axis({ label: '', unit: '', log }); a.show(low, high); return a.ticks(5).map(t => t[1]).join(); };";
    let title = "[ticks(true, 1e-13, 1e-11), ticks(false, -0.04, 1), ticks(false, 1.2345, 1.2349), ticks(false, 0, 4e-7)].join('; ')";
    sandbox
        .put("ticks.html", &format!("<meta charset=utf-8><script>{script};{ticks}document.title = {title}</script>"));
    let Some(dom) = dom(&sandbox, "ticks.html") else { return };
    let decades = "10⁻¹³,2·10⁻¹³,5·10⁻¹³,10⁻¹²,2·10⁻¹²,5·10⁻¹²,10⁻¹¹";
    let want = format!("{decades}; 0,0.5,1; 1.2345,1.2346,1.2347,1.2348,1.2349; 0,1e-7,2e-7,3e-7,4e-7");
    assert!(dom.contains(&want), "{dom}");
}

/// Returns the final document of Chromium; `None` without Chromium.
#[track_caller]
fn dom(sandbox: &Sandbox, page: &str) -> Option<String> {
    let profile = tempfile::tempdir().unwrap();
    let mut command = Command::new("chromium");
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]);
    command.args(["--disable-component-update", "--disable-sync", "--virtual-time-budget=5000", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    let Ok(reported) = command.arg(format!("file://{}", sandbox.path(page).display())).output() else {
        skipped("chromium", "no Chromium, so no page is opened");
        return None;
    };
    Some(String::from_utf8_lossy(&reported.stdout).into_owned())
}

/// Opens pages and checks that every plot is drawn without script errors or network requests.
#[track_caller]
fn browse(sandbox: &Sandbox, pages: &[&str]) {
    for name in pages {
        let plots = Page::of(sandbox, name).plots.len();
        let Some(dom) = dom(sandbox, name) else { return };
        let root = dom.split('>').find(|t| t.trim_start().starts_with("<html")).unwrap_or_default();
        for want in [format!("data-ready=\"{plots}\""), "data-errors=\"0\"".into(), "data-violations=\"0\"".into()] {
            assert!(root.contains(&want), "{name}: no {want} in {root}>");
        }
        // the moving instrument has one more canvas
        let film = dom.matches("id=\"filmCanvas\"").count();
        assert_eq!(dom.matches("<canvas").count() - film, plots, "{name}: a canvas for each plot");
        // the names of curves are below the canvas
        assert_eq!(dom.matches("class=\"chart\"").count(), plots, "{name}");
    }
}
