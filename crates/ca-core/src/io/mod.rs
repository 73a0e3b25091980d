//! Ports: the connections between a scene and the outside.
//!
//! A position port *is* a MAT, moved from outside and subject to the force of its links. A force port is a force added
//! to a MAT. Links therefore do not need to know about ports. Outputs are displacements from rest and forces, never
//! absolute positions, so an instrument at rest is silent at any position.

use crate::kind::{ANY, Kind, Need, POSITIVE, Param, PortRole, Role, Type, Unit};

pub mod midi;

crate::choice::choice! {
    /// Quantity of a MAT that an output reads.
    pub enum Hear {
        /// displacement from rest \[m\]
        Position = "position",
        /// speed: change of position in a tick, over the tick \[m/s\]
        Speed = "speed",
        /// acceleration: change of speed in a tick, over the tick \[m/s²\]
        Acceleration = "acceleration",
        /// sum of the forces on it \[N\]
        Force = "force",
    }
}

/// Parameter `hear` of SOX.
pub const HEAR: Param = Param::new(
    "hear",
    Type::Choice(Hear::WORDS),
    Need::Default(0.0),
    "what of it: its position, its speed as a coil does [m/s], its acceleration [m/s^2], or the force on it [N]",
);
const MINUS: Param =
    Param::new("minus", Type::Module, Need::Optional, "the MAT of which the same is taken away, as of two coils");

/// All port kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[&ENX, &ENF, &SOX, &SOF, &TGR];

const X: Param = Param::new(
    "x",
    Type::Position { unit: Unit::METRE },
    Need::Default(0.0),
    "where it stands before anything is heard",
);
const ALONG: Param =
    Param::new("along", Type::Direction, Need::Optional, "in space: the direction it hears or pushes; required there");
const MIDI: Param = Param::new(
    "midi",
    Type::Midi,
    Need::Optional,
    "how a MIDI note or controller moves it: { note = \"C4\", to = \"5 mm\" }",
);
const GAIN: Param =
    Param::number("gain", Unit::NONE, ANY, Need::Default(1.0), "factor to full scale; a value of 1 is the loudest");
const DC: Param = Param::number(
    "dc",
    Unit::HERTZ,
    POSITIVE,
    Need::Optional,
    "takes away what is steady, by a high pass of this cut-off; 0 for none; 7 Hz where an LPR feeds it, else none",
)
.for_good();
const CHANNEL: Param = Param::new(
    "channel",
    Type::Count { min: 0, max: 255 },
    Need::Optional,
    "sound channel, from 0; one of its own, in document order, if left out",
);

/// Position in.
pub static ENX: Kind = Kind {
    code: "ENX",
    title: "position input",
    equation: "x = input",
    doc: "A point moved from outside, once per sound sample: by a gesture file, a MIDI file, a WAV channel or the \
          `[gesture]` of the model. It feels the force of its links and does not yield. The first value only places it.",
    source: &["CMJ 1993"],
    params: &[X, MIDI],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[ENX]
finger = { x = "-2 mm" }
[BUT]
push = { between = ["finger", "bar"], k = "5 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "bar", gain = 500 }
[gesture]
finger = [[0, "-2 mm"], [0.1, "1 mm"], [0.11, "-2 mm"]]
"#,
    role: Role::Port(PortRole::Enx),
};

/// Force in.
pub static ENF: Kind = Kind {
    code: "ENF",
    title: "force input",
    equation: "f += input",
    doc: "A force from outside on a MAT, once per sound sample.",
    source: &["CMJ 1993"],
    params: &[Param::new("to", Type::Module, Need::Required, "the MAT it pushes"), MIDI, ALONG],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[ENF]
blow = { to = "bar" }
[SOX]
out = { from = "bar", gain = 500 }
[gesture]
blow = [[0, 0], [0.001, "2 N"], [0.002, 0]]
"#,
    role: Role::Port(PortRole::Enf),
};

/// Position out.
pub static SOX: Kind = Kind {
    code: "SOX",
    title: "position output",
    equation: "out = gain (x - rest), or of its speed, its acceleration, the force on it",
    doc: "A pickup on a MAT: its displacement from rest in metres, or what `hear` says, times `gain`. One channel each \
          unless they share a `channel`. `minus` takes away the same of another MAT. Speed is the mean over the tick \
          before: late by half a tick.",
    source: &["CMJ 1993"],
    params: &[
        Param::new("from", Type::Module, Need::Required, "the MAT it hears; a point `low@0.3` may move"),
        GAIN,
        CHANNEL,
        DC,
        ALONG,
        HEAR,
        MINUS,
    ],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s", dx0 = "1 mm" }
[SOX]
out = { from = "bar", gain = 500 }
coil = { from = "bar", gain = 0.3, hear = "speed" }
"#,
    role: Role::Port(PortRole::Sox),
};

/// Force out.
pub static SOF: Kind = Kind {
    code: "SOF",
    title: "force output",
    equation: "out = gain F",
    doc: "Hears the force of a LIA, or the summed force on a MAT: the bridge of a string, the bow on the hair.",
    source: &["CMJ 1993"],
    params: &[Param::new("from", Type::Module, Need::Required, "the LIA or MAT it hears"), GAIN, CHANNEL, DC, ALONG],
    one_of: &[],
    example: r#"
[SOL]
bridge = {}
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s", dx0 = "1 mm" }
[RES]
string = { between = ["bridge", "bar"], k = "100 N/m" }
[SOF]
out = { from = "string", gain = 5 }
"#,
    role: Role::Port(PortRole::Sof),
};

/// Degree of freedom of a device.
pub static TGR: Kind = Kind {
    code: "TGR",
    title: "device key",
    equation: "x = position of the device, f = force to the hand",
    doc: "One degree of freedom of a force-feedback device: position in and force out at the gesture rate, across an \
          exact border to the sound rate. Offline it is moved by a gesture like an ENX.",
    source: &["ICMC 2013"],
    params: &[
        Param::new("device", Type::Text, Need::Optional, "name of the device"),
        Param::new(
            "dof",
            Type::Counts { min: 0, max: 127 },
            Need::Default(0.0),
            "degree of freedom of the device, which moves at most 32; in space a list, for x, y and z in this order: axes without one are fixed",
        ),
        X,
        MIDI,
    ],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[TGR]
key = { device = "tgr12", dof = 0, x = "-2 mm" }
[MAS]
hammer = { m = "5 g", x = "-1 mm" }
[REF]
shank = { between = ["key", "hammer"], k = "2 kN/m" }
[BUT]
strike = { between = ["hammer", "bar"], k = "20 kN/m", z = "0.5 N s/m" }
[SOX]
out = { from = "bar", gain = 500 }
[gesture]
key = [[0, "-2 mm"], [0.03, "0 mm"], [0.06, "-2 mm"]]
"#,
    role: Role::Port(PortRole::Tgr),
};
