"""A disc cam from a lift table, made of plain data without any file."""

# %% The lift: cam angle in degrees, lift in mm, with the scatter of a measurement. Take yours from a spreadsheet.
import numpy as np

import camgeom

angle = np.linspace(0.0, 360.0, 145)
lift = 12.0 * np.sin(np.radians(angle) / 2.0) ** 4
lift[1:-1] += np.random.default_rng(1).normal(0.0, 2e-3, len(lift) - 2)
rise, fall = angle <= 180.0, angle >= 180.0
lift[angle == 180.0] = 12.0

# %% A profile is a dict of the tables of its TOML file; arrays may stand in it.
profile = {
    "name": "disc from a lift table",
    "cam": {"kind": "disc", "base_radius": 35, "width": 14, "bore": 20},
    "follower": {"kind": "translating", "mass": 0.6},
    "roller": {"diameter": 20, "length": 14},
    "motion": [
        {"until": 180, "to": 12, "law": "table", "rows": np.column_stack([angle, lift])[rise]},
        {"until": 360, "to": 0, "law": "table", "rows": np.column_stack([angle, lift])[fall]},
    ],
    "operation": {"speed": 400, "spring_rate": 6, "spring_preload": 80},
}
model = camgeom.read(profile)

# %% The smoothed motion against the table, in micrometres.
away = 1e3 * (model.motion(np.radians(angle[:-1])).s - lift[:-1])
print(f"the motion stays within {np.abs(away).max():.1f} um of the table, {away.std():.1f} um rms")

# %% The verdict, each finding with its place.
for finding in camgeom.check(model):
    print(f"{finding.level:5} {finding.check}: {finding.shown} {finding.unit} {finding.place}")

# %% The profile as points of the cam, mm: what a grinder or a wire eroder wants.
points = model.outline(np.radians(np.arange(0.0, 360.0, 0.5)))
print(points.shape, f"radius {np.hypot(*points.T).min():.3f} to {np.hypot(*points.T).max():.3f} mm")

# %% The profile as a file, for the command line.
print(model.toml()[:300])
