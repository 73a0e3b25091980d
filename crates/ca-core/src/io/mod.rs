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
    "quantity of the MAT: displacement from rest [m], speed [m/s] as a coil measures, acceleration [m/s^2], or the \
     force on it [N]",
);
const MINUS: Param = Param::new(
    "minus",
    Type::Module,
    Need::Optional,
    "MAT whose same quantity is subtracted, as with two opposed coils",
);

/// All port kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[&ENX, &ENF, &SOX, &SOF, &TGR];

const X: Param =
    Param::new("x", Type::Position { unit: Unit::METRE }, Need::Default(0.0), "position at load, before any input");
const ALONG: Param =
    Param::new("along", Type::Direction, Need::Optional, "direction of the output or of the force; required in space");
const MIDI: Param = Param::new(
    "midi",
    Type::Midi,
    Need::Optional,
    "how a MIDI note or controller moves it: { note = \"C4\", to = \"5 mm\" }",
);
const GAIN: Param = Param::number(
    "gain",
    Unit::NONE,
    ANY,
    Need::Default(1.0),
    "factor from the quantity to the sample value; full scale is 1",
);
const DC: Param = Param::number(
    "dc",
    Unit::HERTZ,
    POSITIVE,
    Need::Optional,
    "cut-off of a high pass that removes the steady part; 0 for none; if left out, 7 Hz where an LPR feeds the output, \
     else none",
)
.for_good();
const CHANNEL: Param = Param::new(
    "channel",
    Type::Count { min: 0, max: 255 },
    Need::Optional,
    "sound channel, from 0; if left out, a separate one for each output, in document order",
);

/// Position in.
pub static ENX: Kind = Kind {
    code: "ENX",
    title: "position input",
    equation: "x = input",
    doc: "A point whose position comes from outside, once per sound sample: from a gesture file, a MIDI file, a WAV \
          channel or the `[gesture]` of the model. The forces of its links act on it but do not move it. The first \
          value sets its position without a speed.",
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
    doc: "A force on a MAT that comes from outside, once per sound sample.",
    source: &["CMJ 1993"],
    params: &[Param::new("to", Type::Module, Need::Required, "MAT on which the force acts"), MIDI, ALONG],
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
    equation: "out = gain (x - rest), or gain times the speed, the acceleration or the force on it",
    doc: "A pickup on a MAT: its displacement from rest in metres, or the quantity chosen by `hear`, times `gain`. \
          Each output has a separate channel unless several name the same `channel`. `minus` subtracts the same \
          quantity of another MAT. The speed is the mean over the last tick, so it is late by half a tick.",
    source: &["CMJ 1993"],
    params: &[
        Param::new("from", Type::Module, Need::Required, "MAT to measure; a point such as `low@0.3` may move"),
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
    doc: "Outputs the force of a LIA, or the sum of the forces on a MAT, for example at the bridge of a string or at \
          the hair of a bow.",
    source: &["CMJ 1993"],
    params: &[
        Param::new("from", Type::Module, Need::Required, "LIA or MAT whose force is the output"),
        GAIN,
        CHANNEL,
        DC,
        ALONG,
    ],
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
    doc: "One degree of freedom of a force-feedback device. It receives a position and returns a force at the gesture \
          rate; the conversion to and from the sound rate conserves energy. Offline, a gesture moves it like an ENX.",
    source: &["ICMC 2013"],
    params: &[
        Param::new("device", Type::Text, Need::Optional, "name of the device"),
        Param::new(
            "dof",
            Type::Counts { min: 0, max: 127 },
            Need::Default(0.0),
            "degree of freedom of the device, which has at most 32; in space a list for x, y and z, in this order; \
             axes that are not listed are fixed",
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
