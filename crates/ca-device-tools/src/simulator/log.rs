//! Force log of a simulated device. Each line has the number and time of a frame; the number of the force, the frame
//! that it answers, its mode, the reason for no force, and its flags; then the positions and the forces held.

use crate::ToolError;
use ca_haptic::frame::{Cause, DeviceFrame, ForceFrame, Mode};
use ca_haptic::simulated::Device;
use ca_io::error::reason;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;

/// Writes a line for each frame of a simulated device.
pub(super) struct Log {
    to: BufWriter<File>,
    path: String,
    line: String,
}

impl Log {
    pub(super) fn create(path: &Path, n: usize) -> Result<Log, ToolError> {
        let name = path.display().to_string();
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(true)
            .mode(0o644)
            .open(path)
            .map_err(|e| ToolError::Failed(format!("`{name}` cannot be written: {}", reason(&e))))?;
        let mut log = Log { to: BufWriter::with_capacity(1 << 16, file), path: name, line: String::new() };
        log.line += "seq,time,force,answers,mode,off,flags";
        for what in ["x", "f"] {
            for k in 0..n {
                let _ = write!(log.line, ",{what}{k}");
            }
        }
        log.put()?;
        Ok(log)
    }

    pub(super) fn line(
        &mut self,
        frame: &DeviceFrame,
        f: Option<&ForceFrame>,
        off: Cause,
        d: &Device,
    ) -> Result<(), ToolError> {
        self.line.clear();
        let (seq, ack, flags) = f.map_or((0, 0, 0), |f| (f.seq, f.ack, f.flags));
        let mode = f.map_or("none", |f| Mode::read(f.mode).name());
        let _ = write!(self.line, "{},{},{seq},{ack},{mode},{},{flags}", frame.seq, d.time(), off.name());
        for v in d.measured().iter().chain(d.held()) {
            let _ = write!(self.line, ",{v}");
        }
        self.put()
    }

    fn put(&mut self) -> Result<(), ToolError> {
        let written = writeln!(self.to, "{}", self.line);
        written.map_err(|e| ToolError::Failed(format!("`{}` cannot be written: {}", self.path, reason(&e))))
    }

    pub(super) fn finish(mut self) -> Result<(), ToolError> {
        let written = self.to.flush();
        written.map_err(|e| ToolError::Failed(format!("`{}` cannot be written: {}", self.path, reason(&e))))
    }
}
