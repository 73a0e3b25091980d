//! Gestures: movements of a hand, read from a file.
//!
//! CSV, NPY, WAV and Standard MIDI files all become the same: a few named [`Track`]s. The engine thus has one way to be
//! driven, and a take can be edited in any program. The whole file is read and checked at once: a bad number in the
//! last line is an error before the first tick, never during a performance. This costs eight bytes per sample, 23 MB a
//! minute for one channel at 48 kHz.
//!
//! | file | names of tracks | time |
//! |---|---|---|
//! | `.csv` | from the header | column `time` \[s\] |
//! | `.npy` | fields of its dtype; `ch0`, `ch1`, … without fields | field `time` \[s\], or the rate given |
//! | `.wav` | `ch0`, `ch1`, … | its sample rate |
//! | `.mid`, `.midi`, `.smf`, `.kar`, `.rmi` | the ports that it moves | its tempo map |

use crate::error::{FileError, shown};
#[cfg(feature = "files")]
use crate::{error::FileErrorKind, read_limited};
use ca_core::internal::io::midi::MidiMap;
use ca_core::{Input, Scene};
use std::path::Path;

#[cfg(feature = "files")]
pub(crate) mod csv;
#[cfg(feature = "files")]
mod midi;
mod midi_port;
#[cfg(feature = "files")]
mod npy;
#[cfg(feature = "files")]
mod riff;
#[cfg(feature = "files")]
mod smf;
mod track;
#[cfg(feature = "files")]
pub(crate) mod wav;

pub use midi_port::{Glide, MidiPort, Motion};
#[cfg(feature = "files")]
pub(crate) use track::check_rate;
pub use track::{Cursor, Curve, LONGEST, Track};

/// Mapping from MIDI to one port of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct PortMap {
    /// Name of the port.
    pub port: String,
    /// Notes, controller, bend or pressure, and their values in the unit of the port.
    pub map: MidiMap,
}

/// Returns the ports of a scene that listen to MIDI.
pub fn port_maps(scene: &Scene) -> Vec<PortMap> {
    let map = |i: &Input| Some(PortMap { port: i.name.clone(), map: i.midi? });
    scene.inputs.iter().filter_map(map).collect()
}

/// File format of a gesture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GestureFormat {
    /// Text: `time, name…`.
    Csv,
    /// NumPy array.
    Npy,
    /// Sound, one track per channel.
    Wav,
    /// Standard MIDI File.
    Midi,
}

impl GestureFormat {
    /// Returns the format for the extension of `path`.
    pub fn of(path: &Path) -> Option<GestureFormat> {
        let ext = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match ext.as_str() {
            "csv" => GestureFormat::Csv,
            "npy" => GestureFormat::Npy,
            "wav" | "wave" => GestureFormat::Wav,
            "mid" | "midi" | "smf" | "kar" | "rmi" => GestureFormat::Midi,
            _ => return None,
        })
    }
}

/// Named tracks that are played together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gesture {
    tracks: Vec<Track>,
    remarks: Vec<String>,
    midi: bool,
}

impl Gesture {
    /// Makes a gesture of these tracks, whose names must differ.
    ///
    /// # Errors
    /// If a track has no name, or two have the same name.
    pub fn new(tracks: Vec<Track>) -> Result<Gesture, FileError> {
        for (i, t) in tracks.iter().enumerate() {
            if t.name().is_empty() {
                return Err(FileError::content(format!("track {i} has no name")).fix("name it after the port it moves"));
            }
            if tracks[..i].iter().any(|u| u.name() == t.name()) {
                let e = FileError::content(format!("two tracks are called `{}`", shown(t.name())));
                return Err(e.fix("rename or remove one"));
            }
        }
        Ok(Gesture { tracks, remarks: Vec::new(), midi: false })
    }

    /// Combines several gestures.
    ///
    /// # Errors
    /// If two tracks have the same name.
    pub fn together(all: impl IntoIterator<Item = Gesture>) -> Result<Gesture, FileError> {
        let (mut tracks, mut remarks, mut midi) = (Vec::new(), Vec::new(), false);
        for g in all {
            tracks.extend(g.tracks);
            remarks.extend(g.remarks);
            midi |= g.midi;
        }
        Ok(Gesture { remarks, midi, ..Gesture::new(tracks)? })
    }

    /// Returns the gesture with its only track renamed to `name`; `None` if it has several.
    pub fn named(self, name: &str) -> Option<Gesture> {
        let [one] = &self.tracks[..] else { return None };
        let tracks = vec![one.clone().named(name)];
        Some(Gesture { tracks, ..self })
    }

    /// Returns the gesture marked as read from a MIDI file, or not.
    #[must_use]
    pub fn as_midi(self, midi: bool) -> Gesture {
        Gesture { midi, ..self }
    }

    /// Returns all tracks, in the order of the file.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Returns remarks on the file: events that move nothing, and violations of the standard of its format.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Returns true if a MIDI file is part of it; such a gesture is played to its end.
    pub fn is_midi(&self) -> bool {
        self.midi
    }

    /// Returns the track of that name.
    pub fn track(&self, name: &str) -> Option<&Track> {
        self.tracks.iter().find(|t| t.name() == name)
    }

    /// Returns the time of the last value of any track \[s\].
    pub fn duration(&self) -> f64 {
        self.tracks.iter().map(Track::duration).fold(0.0, f64::max)
    }
}

#[cfg(feature = "files")]
impl Gesture {
    /// Reads the file at `path` in the format for its extension.
    ///
    /// `ports` maps MIDI to the model, and is unused for other formats. `rate` \[Hz\] is for arrays without a field
    /// `time`.
    ///
    /// # Errors
    /// If the file cannot be read or is too large, or as [`Gesture::read`].
    pub fn open(path: impl AsRef<Path>, ports: &[PortMap], rate: Option<f64>) -> Result<Gesture, FileError> {
        let path = path.as_ref();
        let format = GestureFormat::of(path).ok_or_else(|| {
            FileError::new(FileErrorKind::Unsupported, "gestures cannot be read from a file with this extension")
                .file(path.display())
                .fix("use a `.csv`, `.npy`, `.wav` or `.mid` file")
        })?;
        let read = if format == GestureFormat::Csv { read_limited::text } else { read_limited::bytes };
        let bytes = read(path, read_limited::GESTURE)?;
        Gesture::read(format, &bytes, ports, rate).map_err(|e| e.file(path.display()))
    }

    /// Reads a gesture from memory; errors name no file.
    ///
    /// # Errors
    /// If the bytes are not of the format, with the line or field, or if `rate` is given for a format with its own
    /// time.
    pub fn read(
        format: GestureFormat,
        bytes: &[u8],
        ports: &[PortMap],
        rate: Option<f64>,
    ) -> Result<Gesture, FileError> {
        if rate.is_some() && format != GestureFormat::Npy {
            return Err(FileError::usage("this format already contains its times").fix("leave out the rate"));
        }
        match format {
            GestureFormat::Csv => csv::read(bytes),
            GestureFormat::Npy => npy::read(bytes, rate),
            GestureFormat::Wav => wav::read(bytes),
            GestureFormat::Midi => midi::read(bytes, ports),
        }
    }
}

/// Returns the tracks of the gesture in a scene, with an error for each that is not a curve over time.
pub fn own(scene: &Scene) -> impl Iterator<Item = Result<Track, FileError>> {
    scene
        .about
        .gestures
        .iter()
        .map(|(name, points)| Track::points(name.clone(), points.iter().map(|p| (p[0], p[1])).collect()))
}

#[cfg(all(test, feature = "files"))]
mod tests {
    use super::*;

    #[test]
    fn extensions_choose_the_reader() {
        for (name, want) in [
            ("a.csv", Some(GestureFormat::Csv)),
            ("a.MID", Some(GestureFormat::Midi)),
            ("a.b.midi", Some(GestureFormat::Midi)),
            ("a.KAR", Some(GestureFormat::Midi)),
            ("a.rmi", Some(GestureFormat::Midi)),
            ("a.Npy", Some(GestureFormat::Npy)),
            ("a.wav", Some(GestureFormat::Wav)),
            ("a.mp3", None),
            ("csv", None),
        ] {
            assert_eq!(GestureFormat::of(Path::new(name)), want, "{name}");
        }
        let e = Gesture::open("take.mp3", &[], None).unwrap_err();
        assert_eq!(e.kind, FileErrorKind::Unsupported);
        assert!(e.to_string().starts_with("`take.mp3`: "), "{e}");
    }

    #[test]
    fn names_differ_and_the_longest_track_counts() {
        let a = Track::points("a", vec![(0.0, 1.0), (2.0, 0.0)]).unwrap();
        let b = Track::sampled("b", 10.0, vec![0.0; 41]).unwrap();
        assert!(Gesture::new(vec![a.clone(), a.clone()]).unwrap_err().to_string().contains("two tracks"));
        assert!(Gesture::new(vec![Track::points("", vec![(0.0, 0.0)]).unwrap()]).is_err());
        let g = Gesture::new(vec![a, b]).unwrap();
        assert_eq!(g.duration(), 4.0);
        assert!(g.track("a").unwrap().moves() && !g.track("b").unwrap().moves() && g.track("c").is_none());
    }

    #[test]
    fn a_rate_is_only_for_arrays() {
        let e = Gesture::read(GestureFormat::Csv, b"time,x\n0,1\n", &[], Some(10.0)).unwrap_err();
        assert_eq!(e.kind, FileErrorKind::Usage);
    }
}
