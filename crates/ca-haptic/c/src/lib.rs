//! The side of a device for C: open, send, force, wait, close.
//!
//! Decides that a handle is a number, not a pointer: a handle that is closed twice, was never open or belongs to another
//! thread is an error and nothing worse. Devices belong to the thread that opened them. Every function says what went
//! wrong with a negative number, and [`ca_device_error`] says it in words. Pointers may be null, where that makes no
//! sense it is an error; what they point to must be a whole structure. No panic crosses into C.
#![allow(unsafe_code)]

use ca_haptic::frame::{About, DOF, DeviceFrame, ForceFrame};
use ca_haptic::host::{DeviceClient, Site};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

thread_local! {
    static OPEN: RefCell<BTreeMap<u64, DeviceClient>> = const { RefCell::new(BTreeMap::new()) };
    static ERROR: RefCell<CString> = RefCell::new(CString::default());
}

/// Handles given out, by all threads: none is ever two devices.
static HANDLES: AtomicU64 = AtomicU64::new(0);

/// Runs what may fail, keeps the words of a failure and gives `otherwise`.
fn guarded<T>(otherwise: T, work: impl FnOnce() -> Result<T, String>) -> T {
    let what = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => return value,
        Ok(Err(what)) => what,
        Err(_) => "a fault inside ca_device; please report it".to_owned(),
    };
    let what = CString::new(what.replace('\0', " ")).unwrap_or_default();
    // a thread that is ending has nobody to tell
    let _ = ERROR.try_with(|e| e.replace(what));
    otherwise
}

/// Finds the device of a handle and does something with it.
fn with<T>(device: u64, work: impl FnOnce(&mut DeviceClient) -> Result<T, String>) -> Result<T, String> {
    OPEN.try_with(|open| {
        let mut open = open.borrow_mut();
        let client = open.get_mut(&device).ok_or("this device is not open in this thread")?;
        work(client)
    })
    .map_err(|_| "this thread is ending".to_owned())?
}

/// Fills `about` for a device of this name with `n` degrees of freedom at `rate` frames a second, one force vector per
/// `axes` of them (1 for keys, 3 for a stylus); ranges and limits are 0 and yours to fill. 0, or -1.
///
/// # Safety
/// `about` is null or points to a `CaAbout`; `name` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_about(about: *mut About, name: *const c_char, n: u16, axes: u16, rate: u32) -> i32 {
    guarded(-1, || {
        if about.is_null() || name.is_null() {
            return Err("ca_device_about: a null pointer".into());
        }
        if n == 0 || n as usize > DOF || axes == 0 || axes > 3 || !n.is_multiple_of(axes) {
            return Err(format!(
                "ca_device_about: {n} degrees of freedom in vectors of {axes}; 1 to {DOF}, of 1, 2 or 3"
            ));
        }
        // SAFETY: not null; that it ends with a zero is the caller's word
        let name = unsafe { CStr::from_ptr(name) }.to_str().map_err(|_| "ca_device_about: the name is not UTF-8")?;
        ca_haptic::host::lines::check_name(name).map_err(|e| e.to_string())?;
        let made = About { n, axes, ..About::new(name, rate, 0) };
        // SAFETY: not null; that it points to a structure of this type is the caller's word
        unsafe { about.write(made) };
        Ok(0)
    })
}

/// Opens a device at the place `root`, or at that of this user (`CA_SHM_ROOT`, `/tmp/ca-<uid>`) where `root` is null.
/// Whether an engine is there does not matter. A handle, or 0.
///
/// # Safety
/// `root` is null or ends with a zero; `about` is null or points to a `CaAbout`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_open(root: *const c_char, about: *const About) -> u64 {
    guarded(0, || {
        if about.is_null() {
            return Err("ca_device_open: `about` is null".into());
        }
        // SAFETY: not null; that it points to a structure of this type is the caller's word
        let about = unsafe { about.read() };
        let site = if root.is_null() {
            Site::of_user()
        } else {
            // SAFETY: not null; that it ends with a zero is the caller's word
            let root = unsafe { CStr::from_ptr(root) }.to_str().map_err(|_| "ca_device_open: `root` is not UTF-8")?;
            Site::at(Path::new(root))
        };
        let site = site.map_err(|e| e.to_string())?;
        let client = DeviceClient::open(&site, about).map_err(|e| e.to_string())?;
        OPEN.try_with(|open| {
            let handle = HANDLES.fetch_add(1, Relaxed) + 1;
            open.borrow_mut().insert(handle, client);
            handle
        })
        .map_err(|_| "this thread is ending".into())
    })
}

/// Sends a frame: positions, velocities, status and buttons are yours; header, device, session, number, acknowledgement
/// and time are filled in. How many read it (0: nobody yet), or -1.
///
/// # Safety
/// `frame` is null or points to a `CaDeviceFrame`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_send(device: u64, frame: *mut DeviceFrame) -> i32 {
    guarded(-1, || {
        if frame.is_null() {
            return Err("ca_device_send: `frame` is null".into());
        }
        with(device, |client| {
            // SAFETY: not null; that it points to a structure of this type is the caller's word
            let mut sent = unsafe { frame.read() };
            let readers = client.send(&mut sent).map_err(|e| e.to_string())?;
            // SAFETY: as above
            unsafe { frame.write(sent) };
            Ok(i32::try_from(readers).unwrap_or(i32::MAX))
        })
    })
}

/// What may reach the motors now, `CA_DOF` numbers \[N\]: zeros after the life of the last frame, when off or at fault.
/// `frame`, where not null, gets the newest frame, for display. The reason why there is no force (a cause, see
/// `CaForceFrame`), 0 if there is one, or -1: then `force` is zero too.
///
/// # Safety
/// `force` is null or points to `CA_DOF` doubles; `frame` is null or points to a `CaForceFrame`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ca_device_force(device: u64, force: *mut f64, frame: *mut ForceFrame) -> i32 {
    guarded(-1, || {
        if force.is_null() {
            return Err("ca_device_force: `force` is null".into());
        }
        let force = force.cast::<[f64; DOF]>();
        // SAFETY: not null; that it points to CA_DOF doubles is the caller's word
        unsafe { force.write([0.0; DOF]) };
        with(device, |client| {
            let give = client.safe_force();
            // SAFETY: as above
            unsafe { force.write(give) };
            if let (false, Some(last)) = (frame.is_null(), client.watch().last()) {
                // SAFETY: not null; that it points to a structure of this type is the caller's word
                unsafe { frame.write(*last) };
            }
            // of the force above, not of one that came meanwhile
            Ok(i32::from(client.watch().cause(ca_haptic::rt::now_ns()) as u16))
        })
    })
}

/// Sleeps until a force frame comes, at most this long \[µs\]. 1 if one came, 0 if not, or -1.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_wait(device: u64, timeout_us: u32) -> i32 {
    guarded(-1, || with(device, |client| Ok(i32::from(client.wait(Duration::from_micros(u64::from(timeout_us)))))))
}

/// Closes a device. 0, or -1 if it is not open in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_close(device: u64) -> i32 {
    guarded(-1, || {
        let client =
            OPEN.try_with(|open| open.borrow_mut().remove(&device)).map_err(|_| "this thread is ending".to_owned())?;
        client.map(|_| 0).ok_or_else(|| "this device is not open in this thread".into())
    })
}

/// What went wrong last in this thread; valid until the next failure in it.
#[unsafe(no_mangle)]
pub extern "C" fn ca_device_error() -> *const c_char {
    ERROR.try_with(|e| e.borrow().as_ptr()).unwrap_or(c"this thread is ending".as_ptr())
}
