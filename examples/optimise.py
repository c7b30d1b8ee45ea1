"""The smallest disc that meets its limits, found with scipy, and the trade against contact pressure as a study."""

# %%
import numpy as np
from scipy.optimize import brentq

import camgeom

model = camgeom.read("profiles/disc_offset_roller.toml")
LIMIT = 25.0  # deg


# %% A requirement as a function of a key; a variant that cannot be built raises with the reason.
def excess(radius: float) -> float:
    """Largest pressure angle beyond the limit, deg."""
    return np.degrees(model.with_(cam__base_radius=radius).pressure_angle.value) - LIMIT


smallest = brentq(excess, 30.0, 120.0, xtol=1e-6)
print(f"base radius {smallest:.3f} mm for {LIMIT} deg")

# %% The trade: a grid of radius and roller, exact figures, verdicts.
grid = {"cam.base_radius": [30.0, 40.0, 50.0, 60.0], "roller.diameter": [16.0, 20.0, 24.0]}
found = camgeom.study(model, grid, only=["flank", "contact", "checks"])
shown = ("cam.base_radius", "roller.diameter", "flank.max_pressure_angle_deg", "contact.peak_pressure_mpa", "verdict")
for row in zip(*(found[name] for name in shown)):
    print(*(f"{value:.4g}" if isinstance(value, float) else value for value in row))

# %% The chosen one, as a file. For searches over many keys and aims: camgeom optimise (docs/search.md).
chosen = model.with_(cam__base_radius=float(np.ceil(smallest)), name="smallest disc")
print(chosen, chosen.toml().splitlines()[0])
