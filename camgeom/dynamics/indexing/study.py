"""One call for the whole of an indexing drive: modes, critical speeds, steady state, transient, sweep, as frozen facts.

Every fact is computed when it is first asked for and only once; `summary` gives the numbers with their units in the
names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from math import degrees
from types import MappingProxyType

import numpy as np

from camgeom.dynamics.indexing.drive import IndexingDrive
from camgeom.dynamics.indexing.measures import (
    EnergyBalance,
    Residual,
    Settles,
    energy_balance,
    residual_vibration,
)
from camgeom.dynamics.indexing.modes import Modes, SpeedClasses, critical_speeds, natural_modes, speed_classes
from camgeom.dynamics.indexing.response import CONSTANT, amplification, at_rest, begun, driven, sweep
from camgeom.dynamics.indexing.system import DriveResponse, Fluctuation, Torque, TorsionSystem
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy
from camgeom.dynamics.linear.budget import sought
from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.dynamics.linear.response import Sweep, periodic_response
from camgeom.dynamics.spec import NOTHING, DynamicsSpec
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

RPM = np.pi / 30.0
NEAR = 0.05
"""share of the operating speed within which a critical speed is named"""
MOST_HARMONICS = 40
MODELLED = {
    "linearisation": "the linearised contact", "stiffness": "a contact whose stiffness varies over the cam angle",
}  # fmt: skip
"""powers of what the contact's model adds, and why: it stores no energy of its own"""
GIVEN: Mapping[str, str] = MappingProxyType({})


@immutable
class IndexingStudy(Settles):
    """The dynamics of an indexing drive at an input speed in rad/s; sweep_speeds (s,) in rad/s, band in rad.

    sources: where contact stiffness and inertias that the [dynamics] table does not give come from. torque: what acts
    on the drive beside its inertias. rigid: the same drive whose cam's body is rigid below its contacts, where this
    one's is not.
    """

    drive: IndexingDrive
    motion: DrivenMotion
    speed: float
    accuracy: Accuracy = STANDARD
    fluctuation: Fluctuation = CONSTANT
    exact: bool = False
    band: float = 1e-4
    sweep_speeds: Floats | None = None
    sources: Mapping[str, str] = field(default_factory=dict)
    torque: Torque | None = None
    rigid: IndexingStudy | None = None

    @cached_property
    def modes(self) -> Modes:
        """Natural frequencies and shapes over the cam angle."""
        return natural_modes(self.drive, self.motion)

    @cached_property
    def classes(self) -> SpeedClasses:
        """First critical speed and speed classes, r/min."""
        return speed_classes(self.modes.lowest_hz()[0])

    @cached_property
    def system(self) -> TorsionSystem:
        """The torsion at the speed, one for all its responses: they share its steps. Raises DesignError."""
        return driven(self.drive, self.motion, self.speed, self.fluctuation, self.torque, self.exact)

    @sought
    def steady(self) -> DriveResponse:
        """Periodic steady state."""
        return periodic_response(self.system, self.accuracy)

    @sought
    def start(self) -> DriveResponse:
        """First turn from rest, its shafts wound up by what acts on them there."""
        still = at_rest(self.drive, self.motion, self.torque)
        return begun(self.system, 1, self.accuracy, still)

    @sought
    def sweep(self) -> Sweep:
        """Steady states over the sweep; ProfileError when no sweep was asked for."""
        if self.sweep_speeds is None:
            raise ProfileError([Problem("dynamics.sweep", "is missing", None, "two speeds in r/min")])
        return self.over(self.sweep_speeds)

    def over(self, speeds: Floats, steps: int | None = None) -> Sweep:
        """Steady states at speeds (s,) in rad/s, in a number of steps a turn where one is given."""
        accuracy = self.accuracy if steps is None else replace(self.accuracy, steps=steps)
        return sweep(self.drive, self.motion, speeds, accuracy, self.fluctuation, self.exact, self.torque)

    @sought
    def residual(self) -> Residual:
        """Vibration left in the dwell of the steady state."""
        return residual_vibration(self.steady, self.band)

    @property
    def half_swing(self) -> float:
        """Half a period of the lowest mode, s: what a vibration needs to show its size."""
        return 0.5 / self.modes.lowest_hz()[0]

    @sought
    def energy(self) -> EnergyBalance:
        """Mean powers of the steady state."""
        return energy_balance(self.steady)

    def summary(self) -> dict[str, object]:
        """The figures of the drive for a result file, units in the names."""
        steady, modes = self.steady, self.modes
        load, contact = steady.peak("load_acceleration"), steady.peak("contact_torque")
        lowest, where = modes.lowest_hz()
        speed_rpm = self.speed / RPM
        return {
            "model": "indexing drive, 11 degrees of freedom",
            "first_frequency_hz": lowest,
            "first_frequency_cam_angle_deg": degrees(where),
            "frequencies_hz": [
                {"block": mode.label, "lowest": float(hz.min()), "highest": float(hz.max())}
                for mode, hz in ((one, one.frequency_hz()) for one in modes.modes if one.oscillates)
            ],
            "indefinite_blocks": [str(item) for item in modes.indefinite],
            "first_critical_speed_rpm": self.classes.first_critical_rpm,
            "low_speed_limit_rpm": self.classes.low_rpm,
            "medium_speed_limit_rpm": self.classes.medium_rpm,
            "speed_class": self.classes.of(speed_rpm),
            "peak_load_acceleration_rad_s2": float(load.magnitude[0]),
            "peak_load_acceleration_cam_angle_deg": degrees(float(load.magnitude_at[0])),
            "amplification": float(amplification(load, self.motion, steady.speed)[0]),
            "peak_load_velocity_rad_s": float(steady.peak("load_velocity").magnitude[0]),
            "peak_contact_torque_n_m": float(contact.magnitude[0]),
            "peak_output_torque_n_m": float(steady.peak("output_torque").magnitude[0]),
            "peak_input_torque_n_m": float(steady.peak("input_torque").magnitude[0]),
            "spectral_radius": float(steady.solution.spectral_radius[0]),
            "input_power_w": float(self.energy.input[0]),
            "dissipated_power_w": float(self.energy.dissipated[0]),
            "applied_power_w": float(self.energy.external[0]),
            "linearisation_power_w": float(self.energy.linearisation[0]),
            "stiffness_power_w": float(self.energy.varying[0]),
            "power_balance_error": float(self.energy.error[0]),
            "power_balance_is": self._obeyed(),
            **steady.certainty(),
            "from_rest_peak_load_acceleration_rad_s2": float(self.start.peak("load_acceleration").magnitude[0]),
            "from_rest_peak_output_torque_n_m": float(self.start.peak("output_torque").magnitude[0]),
            "critical_speeds": self._near_critical(speed_rpm),
            **self._data_figures(),
            **self._dwell_figures(),
            **self._sweep_figures(),
            **({} if self.rigid is None else {"rigid_body": self.rigid._beside()}),
        }

    def _obeyed(self) -> str:
        """What the mean powers of a turn obey."""
        there = {"linearisation": not self.exact, "stiffness": bool(self.drive.contact_table)}
        named = [name for name in MODELLED if there[name]]
        why = f": {' and '.join(MODELLED[name] for name in named)} stores no energy of its own" if named else ""
        return f"{' + '.join(['input', 'applied', *named])} = dissipated{why}"

    def _beside(self) -> dict[str, object]:
        """What stands beside the figures of a drive whose cam's body yields."""
        return {
            "first_frequency_hz": self.modes.lowest_hz()[0],
            "mean_contact_stiffness_n_m_per_rad": self.drive.contact_stiffness,
            "peak_load_acceleration_rad_s2": float(self.steady.peak("load_acceleration").magnitude[0]),
            "peak_contact_torque_n_m": float(self.steady.peak("contact_torque").magnitude[0]),
            **self._dwell_figures(),
        }

    def _near_critical(self, speed_rpm: float) -> list[dict[str, object]]:
        """Critical speeds whose range comes within NEAR of the operating speed."""
        return [
            {
                "block": one.label,
                "mode": one.mode,
                "harmonic": one.order,
                "lowest_rpm": one.lowest_rpm,
                "highest_rpm": one.highest_rpm,
            }
            for one in critical_speeds(self.modes, MOST_HARMONICS)
            if one.lowest_rpm <= (1.0 + NEAR) * speed_rpm and one.highest_rpm >= (1.0 - NEAR) * speed_rpm
        ]

    def _sweep_figures(self) -> dict[str, object]:
        """The sweep, where one was asked for: lists over its speeds, null at a speed without a steady state."""
        if self.sweep_speeds is None:
            return {}
        load = self.sweep.peaks["load_acceleration"]
        columns = {
            "peak_load_acceleration_rad_s2": load.magnitude,
            "amplification": amplification(load, self.motion, self.sweep.speed),
            "spectral_radius": self.sweep.spectral_radius,
        }
        return {"sweep": self.sweep.figures(columns)}

    def _data_figures(self) -> dict[str, object]:
        """Contact stiffness and inertias that the figures rest on, and where they come from."""
        drive = self.drive
        table = drive.contact_table or (drive.contact_stiffness,)
        names = ("contact_stiffness", "cam_inertia", "turret_inertia", "load_inertia")
        return {
            "lowest_contact_stiffness_n_m_per_rad": min(table),
            "mean_contact_stiffness_n_m_per_rad": float(np.mean(table)),
            "highest_contact_stiffness_n_m_per_rad": max(table),
            "cam_inertia_kg_m2": drive.cam_inertia,
            "turret_inertia_kg_m2": drive.turret_inertia,
            "load_inertia_kg_m2": drive.load_inertia,
            "data_from": {name: self.sources.get(name, "given") for name in names},
        }

    def _dwell_figures(self) -> dict[str, object]:
        """Residual vibration, or nothing where the motion has no dwell."""
        if not self.dwells:
            return {}
        found = self.residual
        return {
            "residual_deviation_deg": degrees(float(found.deviation[0])),
            "residual_acceleration_rad_s2": float(found.acceleration[0]),
            "settling_time_s": self.settling_time,
        }


def indexing_study(
    spec: DynamicsSpec,
    motion: DrivenMotion,
    speed_rpm: float,
    contact_table: tuple[float, ...] = (),
    inertias: Mapping[str, float] = NOTHING,
    sources: Mapping[str, str] = GIVEN,
    torque: Torque | None = None,
) -> IndexingStudy:
    """The study a profile's [dynamics] table asks for, at the operating speed in r/min.

    contact_table: K12 in N m/rad at equal steps of a turn (`mechanics.turret_stiffness`), inertias in kg m2 by key:
    used where the table gives none. sources says where they come from; torque acts on the drive.
    """
    return IndexingStudy(
        spec.drive(contact_table, inertias),
        motion,
        speed_rpm * RPM,
        spec.accuracy(),
        spec.speed_fluctuation(),
        spec.exact_contact,
        float(np.radians(spec.settling_band)),
        spec.speeds(),
        sources,
        torque,
    )
