//! Tests sound servers that disappear and return during a performance, and the choice of another server. Servers are
//! real.

use super::audio::{BAR, Jack};
use super::pulse::{SINK, Server, client, ears};
use crate::sandbox::{Proc, Sandbox, until};
use ca_haptic::host::control::Request;

fn ca(sandbox: &Sandbox, jack: Option<&Jack>, pulse: Option<&Server>, args: &[&str]) -> Proc {
    let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), args);
    c.env("JACK_DEFAULT_SERVER", jack.map_or("ca_none", |j| j.name.as_str()));
    c.env("PULSE_SERVER", pulse.map_or_else(|| "unix:/nowhere".into(), |p| format!("unix:{}", p.socket)));
    sandbox.start(c)
}

fn plays(sandbox: &Sandbox) -> String {
    let reply = sandbox.ask(&Request::Audio { to: None });
    reply.map_or_else(String::new, |r| r.fields["plays"].as_str().unwrap_or_default().to_owned())
}

fn frames(sandbox: &Sandbox) -> u64 {
    sandbox.ask(&Request::Status).map_or(0, |r| r.fields["frames"].as_u64().unwrap())
}

/// A model that sounds permanently and has a live parameter, so that it accepts requests.
fn hum() -> String {
    let live = "[param]\nloud = { value = 500, live = true, min = 0, max = 1000 }\n";
    format!("{live}{}", BAR.replace("20 s", "2000 s").replace("gain = 500", "gain = \"loud\""))
}

#[test]
fn a_jack_server_that_dies_leaves_its_sound_to_another_and_has_it_back() {
    let sandbox = Sandbox::new();
    sandbox.put("hum.ca.toml", &hum());
    let Some(mut jack) = Jack::start(&sandbox, 256) else { return };
    let Some(pulse) = Server::start(&sandbox, SINK) else { return };
    let mut served = ca(&sandbox, Some(&jack), Some(&pulse), &["serve", "hum.ca.toml", "--audio", "jack", "--json"]);
    until("JACK plays", || {
        assert!(served.is_running(), "{}", served.stderr());
        plays(&sandbox).contains("(JACK)") && frames(&sandbox) > 3000
    });
    jack.server.take().unwrap().kill();
    until("it is said", || served.stderr().contains("sound: lost JACK"));
    until("PulseAudio plays", || plays(&sandbox).contains("(PulseAudio)"));
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    let begin = frames(&sandbox);
    until("frames go on", || frames(&sandbox) > begin + 3000);
    drop(jack);
    let Some(_jack) = Jack::start(&sandbox, 256) else { panic!("it was there before") };
    until("JACK is back", || served.stderr().contains("it is back") && plays(&sandbox).contains("(JACK)"));
    let begin = frames(&sandbox);
    until("frames go on", || frames(&sandbox) > begin + 3000);
    let reported = served.stop().is(3).json();
    assert_eq!(reported["audio"]["host"], "JACK", "{reported:#}");
    let before: Vec<_> = reported["audio_before"].as_array().unwrap().iter().map(|a| a["host"].clone()).collect();
    assert_eq!(before, ["JACK", "PulseAudio"], "{reported:#}");
    assert_eq!(reported["audio_before"][0]["stops"], 1, "{reported:#}");
}

#[test]
fn a_pulse_server_that_dies_leaves_its_sound_to_the_page_and_has_it_back() {
    let sandbox = Sandbox::new();
    sandbox.put("hum.ca.toml", &hum());
    let Some(mut pulse) = Server::start(&sandbox, SINK) else { return };
    let mut played = ca(&sandbox, None, Some(&pulse), &["play", "hum.ca.toml", "--no-open", "--port", "0", "--json"]);
    until("PulseAudio plays", || {
        assert!(played.is_running(), "{}", played.stderr());
        // a new sink takes two seconds of sound before its next request
        plays(&sandbox).contains("(PulseAudio)") && frames(&sandbox) > 9000
    });
    pulse.server.take().unwrap().kill();
    until("it is said", || played.stderr().contains("sound: lost PulseAudio"));
    until("the page plays", || plays(&sandbox) == "by the page" && played.stderr().contains("sound: by the page"));
    let begin = frames(&sandbox);
    until("frames go on", || frames(&sandbox) > begin + 3000);
    drop(pulse);
    let _ = std::fs::remove_file(sandbox.path("pa.sock"));
    let Some(pulse) = Server::start(&sandbox, SINK) else { panic!("it was there before") };
    until("PulseAudio is back", || played.stderr().contains("it is back") && plays(&sandbox).contains("(PulseAudio)"));
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    played.stop().is(3);
}

#[test]
fn what_plays_is_chosen_while_it_plays() {
    let sandbox = Sandbox::new();
    sandbox.put("hum.ca.toml", &hum());
    let Some(pulse) = Server::start(&sandbox, SINK) else { return };
    let served = ca(&sandbox, None, Some(&pulse), &["serve", "hum.ca.toml", "--json"]);
    until("it answers", || frames(&sandbox) > 0);
    sandbox.ca(&["audio"]).is(0).says(&["sound: none", "`jack`", "`pulse`"]);
    sandbox.ca(&["audio", "jack"]).is(1).says(&["no JACK server answers"]);
    sandbox.ca(&["audio", "page"]).is(1).says(&["`ca serve` does not have a page"]);
    sandbox.ca(&["audio", "pulse"]).is(0).says(&["(PulseAudio), 48000 Hz"]);
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    // an output that does not open leaves the present one unchanged
    sandbox.ca(&["audio", "jack"]).is(1);
    assert!(plays(&sandbox).contains("(PulseAudio)"));
    let before = heard.lock().unwrap().len();
    until("it goes on", || heard.lock().unwrap()[before..].iter().any(|x| x.abs() > 0.1));
    let reported = served.stop().json();
    assert_eq!(reported["audio"]["host"], "PulseAudio", "{reported:#}");
    assert_eq!(reported["audio_before"].as_array().map(Vec::len), Some(0), "{reported:#}");
}
