"""Measured points of a finished cam fitted to its exact flank: form deviation, and how the part lay on the machine."""

# %% A "measurement": points of the flank, turned by 0.2 deg, shifted along the axis, with the scatter of a machine.
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import camgeom
from camgeom.inspection import inspect
from camgeom.inspection.points import read_points

model = camgeom.read("profiles/pin_insertion.toml")
phi = np.radians(np.arange(1.0, 360.0, 4.0))
points = model.flank(+1.0, phi, stations=3).points[:, 1:2].reshape(-1, 3)
turn, shift = np.radians(0.2), np.array([0.0, 0.0, 0.05])
c, s = np.cos(turn), np.sin(turn)
measured = points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T + shift
measured += np.random.default_rng(2).normal(0.0, 5e-4, measured.shape)

# %% The file of the measuring machine, and the best fit: angle about the axis and shift along it.
with TemporaryDirectory() as folder:
    file = Path(folder, "points.csv")
    np.savetxt(file, measured, delimiter=",", header="x,y,z", comments="")
    found = inspect(model, read_points(file))
print(f"the part lay turned by {np.degrees(found.angle):.4f} deg and shifted by {found.shift.round(4)} mm")
print(f"form deviation {found.of().smallest * 1e3:.2f} to {found.of().largest * 1e3:.2f} um")

# %% Deviation over the cam angle, for a chart of your own.
worst = np.argsort(np.abs(found.deviation))[-3:]
for i in worst:
    print(f"{np.degrees(found.feet.phi[i]):.1f} deg: {found.deviation[i] * 1e3:+.2f} um")
