"""The smallest device in Python: a damped finger of 100 g moved by the force of the engine.

    pip install "./crates/ca-py[device]"
    python device.py finger 3000
"""

import sys

from cordis_anima.device import Device

name, frames = (sys.argv[1:] + ["finger", "3000"][len(sys.argv) - 1 :])[:2]
x = v = most = 0.0
felt = 0
with Device(name, low=-0.02, high=0.02, force=10.0, rate=1000, simulated=True) as device:
    for _ in range(int(frames)):
        device.send(x)
        force = device.force()[0]
        v = (v + force / 0.1 * 0.001) / (1 + 2.0 / 0.1 * 0.001)  # 0.1 kg, 2 N s/m, 1 ms
        x, felt, most = x + v * 0.001, felt + (force != 0), max(most, abs(force))
        device.wait()
    print(f"sent {frames} seen {device.seen} felt {felt} most {most:.3f} x {x:.6f} mode {device.mode}")
