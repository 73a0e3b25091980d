//! Tests sound servers that disappear and return during a performance, and the choice of another server. Servers are
//! real.

use super::audio::{BAR, Jack};
use super::pulse::{SINK, Server, client, ears};
use crate::stage::{Proc, Stage, until};
use ca_haptic::host::control::Request;

fn ca(stage: &Stage, jack: Option<&Jack>, pulse: Option<&Server>, args: &[&str]) -> Proc {
    let mut c = stage.command(env!("CARGO_BIN_EXE_ca"), args);
    c.env("JACK_DEFAULT_SERVER", jack.map_or("ca_none", |j| j.name.as_str()));
    c.env("PULSE_SERVER", pulse.map_or_else(|| "unix:/nowhere".into(), |p| format!("unix:{}", p.socket)));
    stage.start(c)
}

fn plays(stage: &Stage) -> String {
    let reply = stage.ask(&Request::Audio { to: None });
    reply.map_or_else(String::new, |r| r.fields["plays"].as_str().unwrap_or_default().to_owned())
}

fn frames(stage: &Stage) -> u64 {
    stage.ask(&Request::Status).map_or(0, |r| r.fields["frames"].as_u64().unwrap())
}

/// A model that sounds permanently and has a live parameter, so that it accepts requests.
fn hum() -> String {
    let live = "[param]\nloud = { value = 500, live = true, min = 0, max = 1000 }\n";
    format!("{live}{}", BAR.replace("20 s", "2000 s").replace("gain = 500", "gain = \"loud\""))
}

#[test]
fn a_jack_server_that_dies_leaves_its_sound_to_another_and_has_it_back() {
    let stage = Stage::new();
    stage.put("hum.ca.toml", &hum());
    let Some(mut jack) = Jack::start(&stage, 256) else { return };
    let Some(pulse) = Server::start(&stage, SINK) else { return };
    let mut served = ca(&stage, Some(&jack), Some(&pulse), &["serve", "hum.ca.toml", "--audio", "jack", "--json"]);
    until("JACK plays", || {
        assert!(served.lives(), "{}", served.said());
        plays(&stage).contains("(JACK)") && frames(&stage) > 3000
    });
    jack.server.take().unwrap().kill();
    until("it is said", || served.said().contains("sound: lost JACK"));
    until("PulseAudio plays", || plays(&stage).contains("(PulseAudio)"));
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    let begin = frames(&stage);
    until("frames go on", || frames(&stage) > begin + 3000);
    drop(jack);
    let Some(_jack) = Jack::start(&stage, 256) else { panic!("it was there before") };
    until("JACK is back", || served.said().contains("it is back") && plays(&stage).contains("(JACK)"));
    let begin = frames(&stage);
    until("frames go on", || frames(&stage) > begin + 3000);
    let reported = served.stop().is(3).json();
    assert_eq!(reported["audio"]["host"], "JACK", "{reported:#}");
    let before: Vec<_> = reported["audio_before"].as_array().unwrap().iter().map(|a| a["host"].clone()).collect();
    assert_eq!(before, ["JACK", "PulseAudio"], "{reported:#}");
    assert_eq!(reported["audio_before"][0]["stops"], 1, "{reported:#}");
}

#[test]
fn a_pulse_server_that_dies_leaves_its_sound_to_the_page_and_has_it_back() {
    let stage = Stage::new();
    stage.put("hum.ca.toml", &hum());
    let Some(mut pulse) = Server::start(&stage, SINK) else { return };
    let mut played = ca(&stage, None, Some(&pulse), &["play", "hum.ca.toml", "--no-open", "--port", "0", "--json"]);
    until("PulseAudio plays", || {
        assert!(played.lives(), "{}", played.said());
        // a new sink takes two seconds of sound before its next request
        plays(&stage).contains("(PulseAudio)") && frames(&stage) > 9000
    });
    pulse.server.take().unwrap().kill();
    until("it is said", || played.said().contains("sound: lost PulseAudio"));
    until("the page plays", || plays(&stage) == "by the page" && played.said().contains("sound: by the page"));
    let begin = frames(&stage);
    until("frames go on", || frames(&stage) > begin + 3000);
    drop(pulse);
    let _ = std::fs::remove_file(stage.path("pa.sock"));
    let Some(pulse) = Server::start(&stage, SINK) else { panic!("it was there before") };
    until("PulseAudio is back", || played.said().contains("it is back") && plays(&stage).contains("(PulseAudio)"));
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    played.stop().is(3);
}

#[test]
fn what_plays_is_chosen_while_it_plays() {
    let stage = Stage::new();
    stage.put("hum.ca.toml", &hum());
    let Some(pulse) = Server::start(&stage, SINK) else { return };
    let served = ca(&stage, None, Some(&pulse), &["serve", "hum.ca.toml", "--json"]);
    until("it answers", || frames(&stage) > 0);
    stage.ca(&["audio"]).is(0).says(&["sound: none", "`jack`", "`pulse`"]);
    stage.ca(&["audio", "jack"]).is(1).says(&["no JACK server answers"]);
    stage.ca(&["audio", "page"]).is(1).says(&["`ca serve` does not have a page"]);
    stage.ca(&["audio", "pulse"]).is(0).says(&["(PulseAudio), 48000 Hz"]);
    let listener = client(&pulse.socket).unwrap();
    let (_stream, heard) = ears(&listener);
    until("it is heard", || heard.lock().unwrap().iter().any(|x| x.abs() > 0.1));
    // an output that does not open leaves the present one unchanged
    stage.ca(&["audio", "jack"]).is(1);
    assert!(plays(&stage).contains("(PulseAudio)"));
    let before = heard.lock().unwrap().len();
    until("it goes on", || heard.lock().unwrap()[before..].iter().any(|x| x.abs() > 0.1));
    let reported = served.stop().json();
    assert_eq!(reported["audio"]["host"], "PulseAudio", "{reported:#}");
    assert_eq!(reported["audio_before"].as_array().map(Vec::len), Some(0), "{reported:#}");
}
