//! What can be typed. Every command says in one line what it is for, then in a paragraph how it thinks, then shows
//! examples that run (tests extract and run them, but for those of `bench`, which take minutes).

use ca_core::Unit;
use ca_model::quantity;
use clap::builder::UnknownArgumentValueParser;
use clap::{Args, CommandFactory as _, Parser, Subcommand, ValueEnum};
use clap_complete::ArgValueCompleter;
use std::any::TypeId;
use std::path::PathBuf;

mod accuracy;
mod bench;
mod completions;
mod device;
mod equiv;
mod explain;
mod fit;
mod modes;
mod play;
mod report;
mod serve;
mod sweep;
mod take;
mod tune;

pub use accuracy::AccuracyArgs;
pub use bench::BenchArgs;
pub use completions::CompletionsArgs;
pub use device::{CalibrateArgs, ConformanceArgs, DeviceArgs, DeviceCommand, ScriptKind, SimArgs};
pub use equiv::EquivArgs;
pub use explain::ExplainArgs;
pub use fit::FitArgs;
pub use modes::ModesArgs;
pub use play::PlayArgs;
pub use report::ReportArgs;
pub use serve::{ArmArgs, AudioArgs, ClockKind, ServeArgs, SetArgs, ShmArgs, ShmWhat, StatusArgs};
pub use sweep::SweepArgs;
pub use take::{LogArgs, LogCommand, ReplayArgs};
pub use tune::{Scale, TuneArgs};

/// Virtual instruments made of masses and interactions (CORDIS-ANIMA).
#[derive(Parser)]
#[command(name = "ca", version, about = "Virtual instruments made of masses and interactions (CORDIS-ANIMA)")]
#[command(max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 ok, 1 failed, 2 usage, 3 finished but degraded (unstable, clipped), 130 interrupted.\n\
                        A model is a file `*.ca.toml`, a MIMS file `*.mdl`, the name of a bundled model (`ca list`), or `-`: standard input.\n\
                        `ca completions --help` says how a shell completes all of it."
)]
pub struct Cli {
    /// what to do
    #[command(subcommand)]
    pub command: Command,
}

/// The command line as it is read: a negative number after an option is its value, to be judged as any other.
pub fn command() -> clap::Command {
    numbers(Cli::command().mut_subcommand("render", |c| c.args(other_names())))
}

/// Names that options of `ca render` have in other programs. clap answers them with the name here.
fn other_names() -> [clap::Arg; 3] {
    [("--format", "bits", "bit-depth"), ("--seconds", "duration", "length"), ("--rate", "sample-rate", "samplerate")]
        .map(|(ours, one, other)| {
            let meant = UnknownArgumentValueParser::suggest_arg(ours);
            clap::Arg::new(one).long(one).alias(other).hide(true).value_parser(meant)
        })
}

/// Whether as little as possible is said: by `--quiet`, or by `--json`, which programs read.
pub fn is_terse(matches: &clap::ArgMatches) -> bool {
    let given = |flag: &str| matches.try_get_one::<bool>(flag).is_ok_and(|v| v.is_some_and(|v| *v));
    given("quiet") || given("json") || matches.subcommand().is_some_and(|(_, m)| is_terse(m))
}

fn numbers(command: clap::Command) -> clap::Command {
    let takes_number = |arg: &clap::Arg| {
        let is = arg.get_value_parser().type_id();
        let of = [TypeId::of::<f64>(), TypeId::of::<u8>(), TypeId::of::<u16>(), TypeId::of::<u32>()];
        !arg.is_positional() && of.into_iter().chain([TypeId::of::<u64>(), TypeId::of::<usize>()]).any(|t| is == t)
    };
    let one = |arg: clap::Arg| if takes_number(&arg) { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(one).mut_subcommands(numbers)
}

/// The commands. What `--help` says of one stands with its arguments; a line here would take its place, and its second
/// paragraph away. Only where several commands have the same arguments it is here.
#[derive(Subcommand)]
pub enum Command {
    Render(RenderArgs),
    Check(CheckArgs),
    Modes(ModesArgs),
    Accuracy(AccuracyArgs),
    Bench(BenchArgs),
    Sweep(SweepArgs),
    Tune(TuneArgs),
    Fit(FitArgs),
    Report(ReportArgs),
    Equiv(EquivArgs),
    List(ListArgs),
    Explain(ExplainArgs),
    New(NewArgs),
    Import(ImportArgs),
    Play(PlayArgs),
    Serve(ServeArgs),
    Set(SetArgs),
    Audio(AudioArgs),
    /// Turns the forces of a running `ca serve` on
    ///
    /// Once armed, forces fade in within a second, as soon as nothing pushes (docs/safety.md, H5); `ca status` says what an armed
    /// device waits for. After a fault forces stay off until somebody arms again; a model that diverged is loaded again first.
    Arm(ArmArgs),
    /// Turns the forces of a running `ca serve` off at once
    ///
    /// Obeyed with the next gesture frame, whatever disk, terminal or queue stands still. The model plays on, and so do
    /// sound and take; `ca arm` turns forces on again. It does not replace a switch that cuts the power of the motors
    /// (docs/safety.md).
    Disarm(ArmArgs),
    /// Shows the state of a running `ca serve`
    ///
    /// Prints the gesture frames and sound samples played since the start, the mode of each device and why its forces are
    /// off, what an armed device waits for, and the records lost; with `--json` also the live parameters in SI units.
    Status(StatusArgs),
    /// Ends a running `ca serve`
    ///
    /// Forces go to zero with the next gesture frame; sound file and take are finished, and the summary is printed there.
    Stop(StatusArgs),
    Replay(ReplayArgs),
    Log(LogArgs),
    Device(DeviceArgs),
    Shm(ShmArgs),
    Completions(CompletionsArgs),
}

/// Which model, and what to change in it.
#[derive(Args, Clone)]
pub struct Source {
    /// `*.ca.toml` file, MIMS `.mdl` file, name of a bundled model, or `-` for standard input
    #[arg(add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// Changes a parameter: of a module (`hammer.m="30 g"`), a `[param]`, or `rate.gesture`; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair)]
    pub set: Vec<(String, String)>,
    /// Sound rate, e.g. "96 kHz" or 96k; the model's own, or 48 kHz
    #[arg(long, value_name = "HZ", value_parser = hertz)]
    pub rate: Option<f64>,
    /// Position of devices within a gesture frame, as `--set rate.border=hold`
    #[arg(long, value_enum)]
    pub border: Option<Border>,
    /// Gesture frames added to the position of each device, as `--set rate.latency=5`
    #[arg(long, value_name = "FRAMES")]
    pub latency: Option<u32>,
    /// Gives the hand no force, as `--set rate.feedback=false`
    #[arg(long)]
    pub no_feedback: bool,
}

impl Source {
    /// A model as it is.
    pub fn of(model: &str) -> Source {
        let model = model.to_owned();
        Source { model, set: Vec::new(), rate: None, border: None, latency: None, no_feedback: false }
    }

    /// What is changed of the border, as names and values of `--set`.
    pub fn crossing(&self) -> impl Iterator<Item = (String, String)> {
        let border =
            self.border.map(|b| ("rate.border", if b == Border::Hold { "hold" } else { "linear" }.to_string()));
        let latency = self.latency.map(|n| ("rate.latency", n.to_string()));
        let mute = self.no_feedback.then(|| ("rate.feedback", "false".to_string()));
        [border, latency, mute].into_iter().flatten().map(|(name, value)| (name.to_string(), value))
    }

    /// All that is changed, in that form.
    pub fn changes(&self) -> impl Iterator<Item = (String, String)> {
        self.set.iter().cloned().chain(self.crossing())
    }
}

/// How long a model is played, and by what.
#[derive(Args)]
pub struct Playing {
    /// How long, e.g. 4 or "4 s"
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// A gesture that plays it (csv, npy, wav, mid, kar, rmi, or a take, mcap); its tracks take the place of built-in ones;
    /// repeatable. The one nameless track of an array or a sound is given to a port by `key=FILE`
    #[arg(long, value_name = "[PORT=]FILE")]
    pub gesture: Vec<String>,
    /// Rate of an NPY gesture without a time of its own
    #[arg(long, value_name = "HZ", value_parser = hertz, requires = "gesture")]
    pub gesture_rate: Option<f64>,
}

/// Where a device is within a gesture frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Border {
    /// on a straight line
    Linear,
    /// where it was read
    Hold,
}

/// Plays a model into a WAV or FLAC file
///
/// The model is played by its built-in gesture, or by files: CSV, NPY, WAV or MIDI, whose tracks are named like the
/// ports and live parameters they drive. The same model, gesture and options give the same bits on every machine. The
/// length is `--seconds`. Without it a MIDI file is played until the sound has died away (60 dB below its peak for half a second), 10 s
/// after the last event at most; else it is `seconds` of the model, else the gesture and 2 s more, at least 3 s. Floats hold what the
/// model makes, beyond full scale too; in 24 and 16 bits that is cut off and counted. A model that diverges is silenced, and the
/// guilty module named: what is cut off or diverged finishes with exit code 3. A pipe gets the same bytes as a file, when the
/// sound is whole; the summary then goes to standard error.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca render hammered_string
  ca render hammered_string -o slow.wav --seconds 6 --set hammer.m='30 g'
  ca render hammered_string -o take.wav --gesture key.csv --format 24
  ca render hammered_string -o small.flac --format 16
  ca render hammered_string -o - | cat > piped.wav
  ca render hammered_string --normalize -1dBFS --no-fade
  ca render hammered_string --probe 'low[3]' --probe strike=blow.csv --seconds '500 ms'
  ca render hammered_string --energy --json
  ca render piano_key --latency 30 --no-feedback
  ca render piano_key --border hold --set rate.filter='18 kHz'")]
pub struct RenderArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// The file, `.wav` or `.flac`, or `-` for standard output; the name of the model in the current directory if left out
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// how it is played
    #[command(flatten)]
    pub playing: Playing,
    /// Samples: 32-bit float (lossless, the default of WAV), 24 bits (the default of FLAC) or 16 bits; `flac` and `flac16` are
    /// FLAC whatever the file is called
    #[arg(long, value_enum)]
    pub format: Option<SampleFormat>,
    /// Cuts off what is beyond full scale in 32-bit floats too, as 24 and 16 bits always do
    #[arg(long)]
    pub ceiling: bool,
    /// Makes the loudest sample just so loud, e.g. -1dBFS
    #[arg(long, value_name = "DBFS", value_parser = dbfs, allow_hyphen_values = true)]
    pub normalize: Option<f64>,
    /// Leaves the end of a sound that goes on as it is; else its last 20 ms are faded where they are above -60 dBFS
    #[arg(long)]
    pub no_fade: bool,
    /// Writes any quantity to a file, `.npy` (default) or `.csv`: `low[3]`, `strike`, `low@0.3`; repeatable. Of a mass or a port
    /// it is how far that is from where it rests (a gesture says where it is), of a link its force
    #[arg(long, value_name = "NAME[=FILE]")]
    pub probe: Vec<String>,
    /// Keeps the energy ledger for the whole length (slower)
    #[arg(long)]
    pub energy: bool,
    /// Has no effect: one thread plays a scene. Accepted for scripts that were written for earlier versions
    #[arg(long, value_name = "N", default_value_t = 1, hide = true)]
    pub threads: u8,
    /// Which passes run the links; `reference` is slower, link by link, and may sum forces in another order: samples are then
    /// the same to rounding, which collisions may amplify to another course of the sound
    #[arg(long, value_enum, default_value_t = Kernel::Fast)]
    pub kernel: Kernel,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Prints the summary as JSON
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

/// Says everything that can be known of a model before it sounds
///
/// Reads, checks and compiles the model, shows every finding with its place and what to do, and sums up: modules,
/// rates, how late force and sound answer a gesture, what the springs at each device key ask of a device, what is proven
/// of stability and which module is nearest to the limit. With `--schedule`, the passes of one
/// tick in order with their cost, measured here and now, and what the compiler left out; beside it the cost that a table
/// of instructions predicts, at what an instruction takes here in a network of links that are looked up one by one. With `--device`, what of it that
/// device can render: each key's stiffness against the device's own and against what stays passive, and to what it is softened
/// where it is beyond, the force over the travel against the largest, degrees of freedom and rates. Exit code 1 with errors, 3 if the model is certainly unstable
/// or asks more of the device than it can give: stiffness, travel, degrees of freedom. A force that only passes the largest is
/// none of these: it is rendered up to that, as at every hard stop.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca check hammered_string
  ca check hammered_string --schedule
  ca check hammered_string --levels
  ca check hammered_string --set hammer.m='30 g' --rate '96 kHz' --json
  ca check harmonic_chain --exact
  ca check piano_key --latency 1
  ca check hammer_piano --device tgr12")]
pub struct CheckArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// Shows the passes of one tick and measures what each costs
    #[arg(long)]
    pub schedule: bool,
    /// Plays the model and shows how loud each output is, and by how much its gain is off
    #[arg(long)]
    pub levels: bool,
    /// Narrows down the largest eigenvalue, and so how much stiffer everything could be
    #[arg(long)]
    pub exact: bool,
    /// Compares with a device: the name of a profile that comes with us, or a file `profile.toml`
    #[arg(long, value_name = "NAME|FILE")]
    pub device: Option<String>,
    /// Checks again whenever the file is saved, until Ctrl-C
    #[arg(long, conflicts_with = "json")]
    pub watch: bool,
    /// Prints `{diagnostics, summary, schedule, levels, device}` as JSON
    #[arg(long)]
    pub json: bool,
}

/// Lists kinds of modules and bundled models, or shows one of them
///
/// Without a name: both lists. With the code of a kind, its page: equation, parameters with unit and range, sources, a
/// complete example. With the name of a bundled model, what it is and how to play it.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca list
  ca list BUT
  ca list hammered_string
  ca list plectrum
  ca list kinds --markdown
  ca list --schema > ca.schema.json")]
pub struct ListArgs {
    /// `kinds`, `models`, `parts`, the code of a kind, the name of a bundled model or of a part
    #[arg(add = ArgValueCompleter::new(completions::listed))]
    pub what: Option<String>,
    /// As JSON
    #[arg(long, conflicts_with_all = ["schema", "markdown"])]
    pub json: bool,
    /// The JSON Schema of model files, for editors
    #[arg(long, conflicts_with = "markdown")]
    pub schema: bool,
    /// The table of kinds as Markdown
    #[arg(long)]
    pub markdown: bool,
}

/// Starts a model of your own
///
/// Writes a small commented model, a struck string, or a copy of a bundled one. A file that exists is left alone
/// unless `--force` is given.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca new mine.ca.toml
  ca new other.ca.toml --from hammered_string
  ca new other.ca.toml --force")]
pub struct NewArgs {
    /// The file to write, `*.ca.toml`
    pub file: PathBuf,
    /// `string`, or the name of a bundled model (`ca list models`)
    #[arg(long, value_name = "NAME", default_value = "string", add = ArgValueCompleter::new(completions::bundled))]
    pub from: String,
    /// Overwrites the file
    #[arg(long)]
    pub force: bool,
}

/// Turns a MIMS model into a model file
///
/// Everything that is guessed, changed or lost is said as a note that points into the MIMS file. Strings and meshes
/// become generators again. Numbers stay as they are, in algorithmic units. The result is compiled and its findings
/// are shown.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca import string.mdl
  ca import string.mdl -o gut.ca.toml --force")]
pub struct ImportArgs {
    /// The MIMS model, `*.mdl`
    pub file: PathBuf,
    /// The file to write; the name of the model in the current directory if left out
    #[arg(short, long, value_name = "FILE.ca.toml")]
    pub output: Option<PathBuf>,
    /// Overwrites the file
    #[arg(long)]
    pub force: bool,
}

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SampleFormat {
    /// 32-bit floats
    F32,
    /// 24-bit integers
    #[value(name = "24")]
    I24,
    /// 16-bit integers
    #[value(name = "16")]
    I16,
    /// FLAC of 24 bits
    Flac,
    /// FLAC of 16 bits
    Flac16,
}

impl SampleFormat {
    /// True for FLAC, independent of the name of the file.
    pub fn is_flac(self) -> bool {
        matches!(self, SampleFormat::Flac | SampleFormat::Flac16)
    }
}

/// Which passes run the links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kernel {
    /// link by link in document order
    Reference,
    /// batches and runs
    Fast,
}

fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().into(), value.trim().into()))
        }
        _ => Err("write it like `hammer.m=30 g`".into()),
    }
}

fn quantity_of(text: &str, unit: Unit, range: (f64, f64)) -> Result<f64, String> {
    let q = quantity::parse(text.trim()).map_err(|e| e.to_string())?;
    if q.has_unit && !q.dim.same(unit.dim) {
        return Err(format!("a quantity in {} is wanted", unit.symbol));
    }
    if q.value < range.0 || q.value > range.1 {
        return Err(format!("it lies between {} and {} {}", range.0, range.1, unit.symbol));
    }
    Ok(q.value)
}

fn count(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| "a whole number from 0 on is wanted".into())
}

/// A rate; `96k` is short for "96 kHz", as in other programs of sound.
fn hertz(text: &str) -> Result<f64, String> {
    let short = text.trim().strip_suffix(['k', 'K']).filter(|n| n.trim().parse::<f64>().is_ok());
    quantity_of(&short.map_or_else(|| text.to_owned(), |n| format!("{n} kHz")), Unit::HERTZ, (1.0, 1e6))
}

/// A level as a part of full scale.
fn dbfs(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches("FS").trim_end_matches("dB").trim();
    match number.parse::<f64>() {
        Ok(v) if (-200.0..=0.0).contains(&v) => Ok(10.0_f64.powf(v / 20.0)),
        _ => Err(format!("`{text}` is no level from -200 to 0 dBFS, such as -1dBFS")),
    }
}

fn metres(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::METRE, (-1.0, 1.0))
}

fn speed(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SPEED, (1e-4, 10.0))
}

/// A time; also in minutes, which models do not have.
fn seconds(text: &str) -> Result<f64, String> {
    let minutes = text.trim().strip_suffix("min").and_then(|n| n.trim().parse::<f64>().ok());
    let text = minutes.map_or_else(|| text.to_owned(), |n| format!("{} s", n * 60.0));
    quantity_of(&text, Unit::SECOND, (1e-6, 86_400.0))
}
