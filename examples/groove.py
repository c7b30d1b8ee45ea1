"""A groove cam from its profile: verdict, curves as arrays, a larger drum, files in memory.

Run it as a script, or cell by cell (# %%) in an editor or notebook, from the root of the repository.
"""

# %% The profile, and the model of it. Nothing is computed yet.
import numpy as np

import camgeom

model = camgeom.read("profiles/pin_insertion.toml")
print(model)

# %% Facts are computed when asked, once. Extremes know where they are.
worst = model.pressure_angle
print(f"largest pressure angle {np.degrees(worst.value):.2f} deg at {np.degrees(worst.cam_angle):.1f} deg")
print(f"hardest contact {model.duty.peak_pressure.value:.0f} MPa, roller life {model.life.life_h.min():.0f} h")

# %% Curves as arrays: cam angle in rad, lengths in mm.
motion = model.motion()
omega = model.profile.operation.speed * 2 * np.pi / 60
print(f"stroke {np.ptp(motion.s):.1f} mm, peak acceleration {1e-3 * omega**2 * np.abs(motion.a).max():.1f} m/s2")
flank = model.flank(stations=5)
print(f"flank points {flank.points.shape}, pressure angle to {np.degrees(flank.pressure_angle().max()):.2f} deg")

# %% Another cam with other keys, judged like a file; the steep drum gets gentler when it grows.
for diameter in (134, 150, 170):
    other = model.with_({"cam.diameter": diameter, "cam.pitch_radius": diameter / 2})
    print(f"diameter {diameter} mm: {np.degrees(other.pressure_angle.value):.2f} deg")

# %% Bodies for other libraries, and a STEP file without a file.
print(model.solid.to_trimesh().is_watertight, len(camgeom.encode(model, "step")), "bytes of STEP")
