"""The smallest device in Python: a damped finger of 100 g that the force of the engine moves.

    pip install iceoryx2==0.10.0
    python device.py finger 3000

It sends where it is 1000 times a second, is moved only by forces that are fresh, for it and meant, and prints what it
saw. The rules of `host/watch.rs` are in `safe_force`, line by line: a device of yours keeps them.
"""

import ctypes as c
import functools
import os
import secrets
import sys
import time

import iceoryx2 as iox

DOF, M, Z, DT = 32, 0.1, 2.0, 0.001  # mass [kg], viscosity [N s/m], time between frames [s]
SIZES = {"uint8": c.c_uint8, "uint16": c.c_uint16, "uint32": c.c_uint32, "uint64": c.c_uint64,
         "float32": c.c_float, "float64": c.c_double}


def fnv(text):
    return functools.reduce(lambda h, b: (h ^ b) * 0x100000001B3 % 2**64, text.encode(), 0xCBF29CE484222325)


def frame(name, magic, fields):
    """A structure from its message definition; `layout` is the hash of that text."""
    text = "".join(f"{kind} {field}\n" for kind, field in (f.split() for f in fields.split(",")))
    typed = []
    for line in text.splitlines():
        kind, field = line.split()
        base, _, count = kind.rstrip("]").partition("[")
        typed.append((field, SIZES[base] * int(count) if count else SIZES[base]))
    of = {"_fields_": typed, "type_name": staticmethod(lambda: f"ca.v1.{name}"), "LAYOUT": fnv(text),
          "MAGIC": int.from_bytes(magic, "little")}
    return type(name, (c.Structure,), of)


HEAD = "uint32 magic,uint32 version,uint64 layout,uint8[16] device,uint64 session,"
DeviceFrame = frame("DeviceFrame", b"caDF", HEAD + (
    "uint64 seq,uint64 ack,uint64 t_device_ns,uint64 t_host_ns,uint64 calibration,uint64 tick,uint32 period_ns,"
    "uint32 status,uint16 cause,uint16 n,uint32 mask,uint32 vel_mask,uint32 buttons,float64[32] pos,float64[32] vel,"
    "float32[32] force_measured,float32[4] quat,float32[4] aux,float32 temperature,uint32 reserved"))
ForceFrame = frame("ForceFrame", b"caFF", HEAD + (
    "uint64 seq,uint64 ack_session,uint64 ack,uint64 t_host_ns,uint64 tick,uint64 calibration,uint32 ttl_us,"
    "uint32 mode,uint16 cause,uint16 n,uint32 flags,float32 inject,uint32 reserved,float32[32] force"))
About = frame("About", b"caAB", HEAD + (
    "uint64 calibration,uint8[32] model,uint8[32] serial,uint8[16] firmware,uint32 rate,uint16 n,uint16 axes,"
    "float32[32] low,float32[32] high,float32[32] force,float32[32] continuous,float32[32] stiffness,"
    "float32[32] damping"))


def main(name, frames):
    root = os.environ.get("CA_SHM_ROOT", f"/tmp/ca-{os.getuid()}").rstrip("/")
    os.makedirs(root, mode=0o700, exist_ok=True)
    config = iox.config.default()
    config.global_cfg.root_path = iox.Path.new(root)
    config.global_cfg.prefix = iox.FileName.new(f"ca1-0.10.0-{fnv(root) % 2**32:08x}_")
    iox.set_log_level_from_env_or(iox.LogLevel.Fatal)
    node = iox.NodeBuilder.new().config(config).create(iox.ServiceType.Ipc)

    def line(end, kind, history):
        service = iox.ServiceName.new(f"ca/v1/{name}/{end}")
        return (node.service_builder(service).publish_subscribe(kind).enable_safe_overflow(True).history_size(history)
                .subscriber_max_buffer_size(4).subscriber_max_borrowed_samples(2).max_publishers(1).max_subscribers(8)
                .max_nodes(32).open_or_create())

    session, uid = secrets.randbits(63) + 1, (c.c_uint8 * 16)(*name.encode())
    fill = lambda kind, **rest: kind(magic=kind.MAGIC, version=1, layout=kind.LAYOUT, device=uid, session=session, **rest)
    sends = line("in", DeviceFrame, 0).publisher_builder().create()
    hears = line("out", ForceFrame, 0).subscriber_builder().create()
    tells = line("about", About, 1).publisher_builder().create()
    about = fill(About, rate=int(1 / DT), n=1, axes=1)
    about.low[0], about.high[0], about.force[0], about.continuous[0] = -0.02, 0.02, 10, 10
    last, rested = None, False

    def safe_force():
        nonlocal last, rested
        while (sample := hears.receive()) is not None:
            f = ForceFrame.from_buffer_copy(sample.payload().contents)
            sample.delete()
            if (f.magic, f.version, f.layout, bytes(f.device)) != (ForceFrame.MAGIC, 1, ForceFrame.LAYOUT, bytes(uid)):
                continue
            if last and f.session == last.session and f.seq <= last.seq:
                continue
            rested = (rested and last.session == f.session) or f.mode not in (1, 2, 3)
            last = f
        if last is None or not rested:
            return 0.0, 10  # nobody there, or not seen at rest: DISCONNECT
        if not 0 <= time.monotonic_ns() - last.t_host_ns <= min(last.ttl_us * 1000, 100_000_000):
            return 0.0, 6  # too old: WATCHDOG_OUT
        if last.mode not in (1, 2, 3):
            return 0.0, 1  # at rest: DISARMED
        x = last.force[0]
        return (x, 0) if abs(x) < float("inf") else (0.0, 7)  # no number: NONFINITE

    x = v = most = 0.0
    felt, cause, due = 0, 10, time.monotonic()
    for seq in range(1, frames + 1):
        if seq % int(1 / DT) == 1:  # once a second
            tells.send_copy(about)
        now = time.monotonic_ns()
        sends.send_copy(fill(DeviceFrame, seq=seq, ack=last.seq if last else 0, t_device_ns=now, t_host_ns=now,
                             period_ns=int(DT * 1e9), status=1 | 2 | 4 | 256, cause=cause, n=1, mask=1,
                             pos=(c.c_double * DOF)(x)))
        force, cause = safe_force()
        v = (v + force / M * DT) / (1 + Z / M * DT)
        x, felt, most = x + v * DT, felt + (force != 0), max(most, abs(force))
        due += DT
        time.sleep(max(0.0, due - time.monotonic()))
    mode = ("off", "ramp", "on", "damp", "fault")[min(last.mode, 4)] if last else "none"
    print(f"sent {frames} seen {last.seq if last else 0} felt {felt} most {most:.3f} x {x:.6f} mode {mode}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "finger", int(sys.argv[2]) if len(sys.argv) > 2 else 3000)
