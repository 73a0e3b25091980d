//! A desktop whose screen nobody sees and whose sound nobody hears: an X server in memory, and a PulseAudio server
//! without a device. A browser needs the first for WebGL, and the second as the clock of its sound.

use super::Ended;
use crate::skipped::skipped;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

pub struct Desktop {
    display: String,
    _screen: Ended,
    _sound: Ended,
    dir: tempfile::TempDir,
}

impl Desktop {
    /// Starts both servers. Returns `None` if one is missing.
    #[track_caller]
    pub fn start() -> Option<Desktop> {
        let dir = tempfile::Builder::new().prefix("caw").tempdir_in("/tmp").unwrap();
        let socket = dir.path().join("socket");
        let mut sound = Command::new("pulseaudio");
        sound.args(["-n", "--daemonize=no", "--use-pid-file=no", "--exit-idle-time=-1"]);
        sound.args(["-L", "module-null-sink rate=48000", "-L"]);
        sound.arg(format!("module-native-protocol-unix auth-anonymous=1 socket={}", socket.display()));
        for name in ["HOME", "XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "PULSE_RUNTIME_PATH", "PULSE_STATE_PATH"] {
            sound.env(name, dir.path());
        }
        let Ok(sound) = sound.stdout(Stdio::null()).stderr(Stdio::null()).spawn().map(Ended) else {
            skipped("pulseaudio", "no PulseAudio, so no other browser plays");
            return None;
        };
        let mut screen = Command::new("Xvfb");
        screen.args(["-displayfd", "1", "-screen", "0", "1440x900x24", "-nolisten", "tcp"]);
        let Ok(mut screen) = screen.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().map(Ended) else {
            skipped("xvfb", "no X server without a screen, so no other browser plays");
            return None;
        };
        let mut number = String::new();
        BufReader::new(screen.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let end = Instant::now() + Duration::from_secs(30);
        while !socket.exists() {
            assert!(Instant::now() < end, "PulseAudio does not start");
            std::thread::sleep(Duration::from_millis(20));
        }
        Some(Desktop { display: format!(":{}", number.trim()), _screen: screen, _sound: sound, dir })
    }

    /// Makes a program run on this desktop, with its files in a folder of its own.
    pub fn used_by(&self, command: &mut Command) {
        let home = self.dir.path();
        command.env("PULSE_SERVER", format!("unix:{}", home.join("socket").display()));
        command.env("DISPLAY", &self.display).env("HOME", home).env("XDG_RUNTIME_DIR", home);
        command.env_remove("WAYLAND_DISPLAY").stdout(Stdio::null());
    }
}
