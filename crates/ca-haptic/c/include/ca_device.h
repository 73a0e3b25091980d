/* Devices for cordis-anima instruments: send positions, get the force on the hand.
 *
 * SI units: m, N, s. All functions may be called whether or not an engine runs. A device belongs to the thread that
 * opened it. Link with -lca_device. Written by a test from the Rust source; do not edit. */

#ifndef CA_DEVICE_H
#define CA_DEVICE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <stddef.h>

#define CA_VERSION 1
#define CA_STATUS_CONNECTED 1
#define CA_STATUS_POWERED 2
#define CA_STATUS_CALIBRATED 4
#define CA_STATUS_IN_USE 8
#define CA_STATUS_DEADMAN 16
#define CA_STATUS_BRAKE 32
#define CA_STATUS_THERMAL 64
#define CA_STATUS_EDGE 128
#define CA_STATUS_SIMULATED 256
#define CA_FLAG_SATURATED 1
#define CA_FLAG_SLEWED 2
#define CA_FLAG_PASSIVITY 4
#define CA_FLAG_OSCILLATION 8
#define CA_FLAG_THERMAL 16
#define CA_FLAG_EDGE 32
#define CA_FLAG_STALE 64
#define CA_FLAG_WAIT_CLEAR 128
#define CA_FLAG_PASSIVITY_OFF 256
#define CA_FLAG_COUPLED 512
#define CA_CAUSE_NONE 0
#define CA_CAUSE_DISARMED 1
#define CA_CAUSE_BUTTON 2
#define CA_CAUSE_DEADMAN 3
#define CA_CAUSE_VELOCITY 4
#define CA_CAUSE_WATCHDOG_IN 5
#define CA_CAUSE_WATCHDOG_OUT 6
#define CA_CAUSE_NONFINITE 7
#define CA_CAUSE_IMPLAUSIBLE 8
#define CA_CAUSE_THERMAL 9
#define CA_CAUSE_DISCONNECT 10
#define CA_CAUSE_SOFTWARE 11
#define CA_CAUSE_MODEL_UNSTABLE 12
#define CA_MODE_OFF 0
#define CA_MODE_RAMP 1
#define CA_MODE_ON 2
#define CA_MODE_DAMP 3
#define CA_MODE_FAULT 4


// Degrees of freedom of the largest device: 24 keys and a margin.
#define CA_DOF 32

// Capabilities of a device, 904 bytes. Texts are UTF-8, padded with zeros.
typedef struct {
  // [`About::MAGIC`].
  uint32_t magic;
  // [`VERSION`].
  uint32_t version;
  // [`About::LAYOUT`].
  uint64_t layout;
  // Name of the device.
  uint8_t device[16];
  // Session, as in its frames.
  uint64_t session;
  // Calibration, as in its frames.
  uint64_t calibration;
  // Make and model.
  uint8_t model[32];
  // Serial number.
  uint8_t serial[32];
  // Firmware version.
  uint8_t firmware[16];
  // Frames a second.
  uint32_t rate;
  // Degrees of freedom.
  uint16_t n;
  // Number of neighbouring DOF in one force vector: 1 for keys, 3 for a stylus.
  uint16_t axes;
  // Least position [m].
  float low[CA_DOF];
  // Largest position [m].
  float high[CA_DOF];
  // Largest force [N].
  float force[CA_DOF];
  // Largest continuous force [N].
  float continuous[CA_DOF];
  // Largest stiffness that it renders [N/m]; 0 if not known.
  float stiffness[CA_DOF];
  // Largest viscosity that it renders [N s/m]; 0 if not known.
  float damping[CA_DOF];
} CaAbout;

// One frame of a device, 792 bytes.
typedef struct {
  // [`DeviceFrame::MAGIC`].
  uint32_t magic;
  // [`VERSION`].
  uint32_t version;
  // [`DeviceFrame::LAYOUT`].
  uint64_t layout;
  // Name of the device, padded with zeros.
  uint8_t device[16];
  // Number that changes whenever the device process starts.
  uint64_t session;
  // Number of the frame in its session, from 1.
  uint64_t seq;
  // `seq` of the force frame that the motors held while the hand came to this position; 0 if not known.
  uint64_t ack;
  // Clock of the device [ns].
  uint64_t t_device_ns;
  // `CLOCK_MONOTONIC` when published [ns].
  uint64_t t_host_ns;
  // Id of the calibration of the positions; 0 for none.
  uint64_t calibration;
  // Sound sample at which the engine used it; 0 on the wire.
  uint64_t tick;
  // Time between frames [ns].
  uint32_t period_ns;
  // Bits of [`status`].
  uint32_t status;
  // Reason why the device itself gives no force, a [`Cause`].
  uint16_t cause;
  // Degrees of freedom in use, at most [`DOF`].
  uint16_t n;
  // Valid positions, a bit each.
  uint32_t mask;
  // Measured velocities, a bit each.
  uint32_t vel_mask;
  // Buttons, a bit each.
  uint32_t buttons;
  // Positions [m].
  double pos[CA_DOF];
  // Velocities [m/s], where measured.
  double vel[CA_DOF];
  // Forces measured [N]; 0 where not.
  float force_measured[CA_DOF];
  // Orientation; zeros if there is none.
  float quat[4];
  // Pressure, grip and the like.
  float aux[4];
  // Temperature of the motors [°C]; 0 if not measured.
  float temperature;
  // Always 0.
  uint32_t reserved;
} CaDeviceFrame;

// One frame of forces, 240 bytes.
typedef struct {
  // [`ForceFrame::MAGIC`].
  uint32_t magic;
  // [`VERSION`].
  uint32_t version;
  // [`ForceFrame::LAYOUT`].
  uint64_t layout;
  // Name of the device, padded with zeros.
  uint8_t device[16];
  // Number that changes whenever the engine starts.
  uint64_t session;
  // Number of the force frame in its session, from 1.
  uint64_t seq;
  // Session of the device whose frame was used.
  uint64_t ack_session;
  // `seq` of the device frame that was used; 0 before any.
  uint64_t ack;
  // `CLOCK_MONOTONIC` when published [ns].
  uint64_t t_host_ns;
  // Sound sample at which it was computed.
  uint64_t tick;
  // Id of the calibration applied; 0 for none.
  uint64_t calibration;
  // Time after which the device ends the force if no other frame came [µs].
  uint32_t ttl_us;
  // A [`Mode`].
  uint32_t mode;
  // A [`Cause`].
  uint16_t cause;
  // Degrees of freedom in use.
  uint16_t n;
  // Bits of [`flag`].
  uint32_t flags;
  // Largest viscosity that the passivity stage added to any DOF [N s/m].
  float inject;
  // Always 0.
  uint32_t reserved;
  // Forces on the hand [N].
  float force[CA_DOF];
} CaForceFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Fills `about` for a device of this name with `n` degrees of freedom at `rate` frames a second, one force vector per
// `axes` of them (1 for keys, 3 for a stylus). Ranges and limits are 0 for you to fill. Returns 0, or -1 on failure.
//
// # Safety
// `about` is null or points to a `CaAbout`; `name` is null or ends with a zero.
int32_t ca_device_about(CaAbout *about, const char *name, uint16_t n, uint16_t axes, uint32_t rate);

// Opens a device in the folder `root`, or in the user's (`CA_SHM_ROOT`, `/tmp/ca-<uid>`) if `root` is null, with or
// without an engine running. Returns a handle, or 0 on failure.
//
// # Safety
// `root` is null or ends with a zero; `about` is null or points to a `CaAbout`.
uint64_t ca_device_open(const char *root, const CaAbout *about);

// Sends a frame. You set positions, velocities, status and buttons; the library fills in header, device, session,
// number, acknowledgement and time. Returns the number of readers (0 without an engine), or -1 on failure.
//
// # Safety
// `frame` is null or points to a `CaDeviceFrame`.
int32_t ca_device_send(uint64_t device, CaDeviceFrame *frame);

// Writes the force for the motors to `force`, `CA_DOF` numbers [N]: zeros after the time to live of the last frame,
// when off or at fault. `frame`, if not null, gets the newest frame, for display. Returns the reason for zero force (a
// cause, see `CaForceFrame`), 0 if there is a force, or -1 on failure, with zero force.
//
// # Safety
// `force` is null or points to `CA_DOF` doubles; `frame` is null or points to a `CaForceFrame`.
int32_t ca_device_force(uint64_t device, double *force, CaForceFrame *frame);

// Sleeps until a force frame comes, at most this long [µs]. Returns 1 if one came, 0 if not, or -1 on failure.
int32_t ca_device_wait(uint64_t device, uint32_t timeout_us);

// Closes a device. Returns 0, or -1 if it is not open in this thread.
int32_t ca_device_close(uint64_t device);

// Returns the message of the last failure in this thread; it is valid until the next one.
const char *ca_device_error(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CA_DEVICE_H */

/* the layout both sides rely on */
#ifndef __cplusplus
_Static_assert(sizeof(CaDeviceFrame) == 792, "size of CaDeviceFrame");
_Static_assert(offsetof(CaDeviceFrame, magic) == 0, "CaDeviceFrame.magic");
_Static_assert(offsetof(CaDeviceFrame, version) == 4, "CaDeviceFrame.version");
_Static_assert(offsetof(CaDeviceFrame, layout) == 8, "CaDeviceFrame.layout");
_Static_assert(offsetof(CaDeviceFrame, device) == 16, "CaDeviceFrame.device");
_Static_assert(offsetof(CaDeviceFrame, session) == 32, "CaDeviceFrame.session");
_Static_assert(offsetof(CaDeviceFrame, seq) == 40, "CaDeviceFrame.seq");
_Static_assert(offsetof(CaDeviceFrame, ack) == 48, "CaDeviceFrame.ack");
_Static_assert(offsetof(CaDeviceFrame, t_device_ns) == 56, "CaDeviceFrame.t_device_ns");
_Static_assert(offsetof(CaDeviceFrame, t_host_ns) == 64, "CaDeviceFrame.t_host_ns");
_Static_assert(offsetof(CaDeviceFrame, calibration) == 72, "CaDeviceFrame.calibration");
_Static_assert(offsetof(CaDeviceFrame, tick) == 80, "CaDeviceFrame.tick");
_Static_assert(offsetof(CaDeviceFrame, period_ns) == 88, "CaDeviceFrame.period_ns");
_Static_assert(offsetof(CaDeviceFrame, status) == 92, "CaDeviceFrame.status");
_Static_assert(offsetof(CaDeviceFrame, cause) == 96, "CaDeviceFrame.cause");
_Static_assert(offsetof(CaDeviceFrame, n) == 98, "CaDeviceFrame.n");
_Static_assert(offsetof(CaDeviceFrame, mask) == 100, "CaDeviceFrame.mask");
_Static_assert(offsetof(CaDeviceFrame, vel_mask) == 104, "CaDeviceFrame.vel_mask");
_Static_assert(offsetof(CaDeviceFrame, buttons) == 108, "CaDeviceFrame.buttons");
_Static_assert(offsetof(CaDeviceFrame, pos) == 112, "CaDeviceFrame.pos");
_Static_assert(offsetof(CaDeviceFrame, vel) == 368, "CaDeviceFrame.vel");
_Static_assert(offsetof(CaDeviceFrame, force_measured) == 624, "CaDeviceFrame.force_measured");
_Static_assert(offsetof(CaDeviceFrame, quat) == 752, "CaDeviceFrame.quat");
_Static_assert(offsetof(CaDeviceFrame, aux) == 768, "CaDeviceFrame.aux");
_Static_assert(offsetof(CaDeviceFrame, temperature) == 784, "CaDeviceFrame.temperature");
_Static_assert(offsetof(CaDeviceFrame, reserved) == 788, "CaDeviceFrame.reserved");
_Static_assert(sizeof(CaForceFrame) == 240, "size of CaForceFrame");
_Static_assert(offsetof(CaForceFrame, magic) == 0, "CaForceFrame.magic");
_Static_assert(offsetof(CaForceFrame, version) == 4, "CaForceFrame.version");
_Static_assert(offsetof(CaForceFrame, layout) == 8, "CaForceFrame.layout");
_Static_assert(offsetof(CaForceFrame, device) == 16, "CaForceFrame.device");
_Static_assert(offsetof(CaForceFrame, session) == 32, "CaForceFrame.session");
_Static_assert(offsetof(CaForceFrame, seq) == 40, "CaForceFrame.seq");
_Static_assert(offsetof(CaForceFrame, ack_session) == 48, "CaForceFrame.ack_session");
_Static_assert(offsetof(CaForceFrame, ack) == 56, "CaForceFrame.ack");
_Static_assert(offsetof(CaForceFrame, t_host_ns) == 64, "CaForceFrame.t_host_ns");
_Static_assert(offsetof(CaForceFrame, tick) == 72, "CaForceFrame.tick");
_Static_assert(offsetof(CaForceFrame, calibration) == 80, "CaForceFrame.calibration");
_Static_assert(offsetof(CaForceFrame, ttl_us) == 88, "CaForceFrame.ttl_us");
_Static_assert(offsetof(CaForceFrame, mode) == 92, "CaForceFrame.mode");
_Static_assert(offsetof(CaForceFrame, cause) == 96, "CaForceFrame.cause");
_Static_assert(offsetof(CaForceFrame, n) == 98, "CaForceFrame.n");
_Static_assert(offsetof(CaForceFrame, flags) == 100, "CaForceFrame.flags");
_Static_assert(offsetof(CaForceFrame, inject) == 104, "CaForceFrame.inject");
_Static_assert(offsetof(CaForceFrame, reserved) == 108, "CaForceFrame.reserved");
_Static_assert(offsetof(CaForceFrame, force) == 112, "CaForceFrame.force");
_Static_assert(sizeof(CaAbout) == 904, "size of CaAbout");
_Static_assert(offsetof(CaAbout, magic) == 0, "CaAbout.magic");
_Static_assert(offsetof(CaAbout, version) == 4, "CaAbout.version");
_Static_assert(offsetof(CaAbout, layout) == 8, "CaAbout.layout");
_Static_assert(offsetof(CaAbout, device) == 16, "CaAbout.device");
_Static_assert(offsetof(CaAbout, session) == 32, "CaAbout.session");
_Static_assert(offsetof(CaAbout, calibration) == 40, "CaAbout.calibration");
_Static_assert(offsetof(CaAbout, model) == 48, "CaAbout.model");
_Static_assert(offsetof(CaAbout, serial) == 80, "CaAbout.serial");
_Static_assert(offsetof(CaAbout, firmware) == 112, "CaAbout.firmware");
_Static_assert(offsetof(CaAbout, rate) == 128, "CaAbout.rate");
_Static_assert(offsetof(CaAbout, n) == 132, "CaAbout.n");
_Static_assert(offsetof(CaAbout, axes) == 134, "CaAbout.axes");
_Static_assert(offsetof(CaAbout, low) == 136, "CaAbout.low");
_Static_assert(offsetof(CaAbout, high) == 264, "CaAbout.high");
_Static_assert(offsetof(CaAbout, force) == 392, "CaAbout.force");
_Static_assert(offsetof(CaAbout, continuous) == 520, "CaAbout.continuous");
_Static_assert(offsetof(CaAbout, stiffness) == 648, "CaAbout.stiffness");
_Static_assert(offsetof(CaAbout, damping) == 776, "CaAbout.damping");
#endif
