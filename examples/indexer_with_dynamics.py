"""A globoidal indexer with its elastic drive: how much the turret shakes at each speed, and when it stands still."""

# %%
import numpy as np

import camgeom

model = camgeom.read("profiles/tool_changer.toml")
print(model)

# %% The drive in its periodic state: what the load feels against the rigid motion.
drive = model.indexing
summary = drive.summary()
for key in ("first_frequency_hz", "amplification", "peak_load_acceleration_rad_s2", "speed_class"):
    print(f"{key}: {summary[key]}")

# %% The same cam faster: amplification over speed, one model a speed.
for speed in (60, 120, 180):
    faster = model.with_(operation__speed=speed)
    found = faster.indexing.summary()
    torque = faster.dynamic_torque
    print(f"{speed} r/min: amplification {found['amplification']:.3f}, camshaft torque {torque.value * 1e-3:.0f} N m")

# %% Who shares the load: forces on the rollers, hardest contact, life.
duty = model.turret_duty
print(f"contact pressure {duty.peak_pressure.value:.0f} MPa")
for body, hours in duty.lives.items():
    print(f"life of the {body} {hours:.3g} h")

# %% The flank of the first roller track as points, to compare with a measurement.
flank = model.flank(stations=3)
print(flank.points.shape, np.abs(flank.points).max(axis=(0, 1)).round(2), "mm")
