"""Impacts in the clearance of a constant-width cam: a study over the clearance, its results as arrays."""

# %%
import numpy as np

import camgeom

model = camgeom.read("profiles/constant_width_press.toml")

# %% One run: the follower knocks to and fro in its clearance.
run = model.impact
print(f"{len(run.impacts)} impacts, hardest contact {model.impact_pressure.value:.0f} MPa")

# %% The same for several clearances; a body's own play follows the key that is varied.
found = camgeom.study(model, {"impact.clearance": np.geomspace(0.005, 0.04, 3)})
pressure = found["dynamics.impact.worst_pressure_mpa"]
for row in zip(found["impact.clearance"], pressure, found["verdict"]):
    print("clearance {:.4f} mm: {:.0f} MPa, {}".format(*row))

# %% A mapping of columns: a DataFrame where pandas is installed.
try:
    print(found.to_pandas().shape)
except camgeom.CamgeomError as error:
    print(error)
