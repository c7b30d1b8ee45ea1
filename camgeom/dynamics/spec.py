"""The `[dynamics]` table of a profile: the elastic drive behind the cam (units at the edge: mm, N, kg, degrees,
r/min).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Literal, Self, final

import numpy as np
from pydantic import Field, field_validator, model_validator

from camgeom.errors import Problem, ProfileError
from camgeom.keys import Section

if TYPE_CHECKING:
    # The solvers: what reads a profile does without them.
    from camgeom.dynamics.follower.train import CamShaft, Closure, FollowerTrain
    from camgeom.dynamics.indexing.drive import IndexingDrive
    from camgeom.dynamics.indexing.system import Fluctuation
    from camgeom.dynamics.linear.accuracy import Accuracy
    from camgeom.dynamics.linear.method import Method

Positive = Annotated[float, Field(gt=0.0, le=1e15, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, le=1e15, allow_inf_nan=False)]
Signed = Annotated[float, Field(ge=-1e15, le=1e15, allow_inf_nan=False)]
Speed = Annotated[float, Field(gt=0.0, le=1e6, allow_inf_nan=False)]
Family = Literal["auto", "wilson", "newmark", "generalized-alpha"]
Gauss = Literal["gauss1", "gauss2", "gauss3", "gauss4", "gauss5", "gauss6", "gauss7", "gauss8"]
Radau = Literal["radau2", "radau3", "radau5"]

LEFT = ("rk4", "magnus2", "magnus4")
"""methods of earlier versions, slower than Gauss stages at every accuracy"""
NOTHING: Mapping[str, float] = MappingProxyType({})
PER_MM = 1000.0
"""N/mm to N/m"""
DRIVE_KEYS = ("input_stiffness", "output_stiffness")
"""what an indexing drive cannot do without"""
INERTIA_KEYS = ("cam_inertia", "turret_inertia", "load_inertia")
"""what follows from the profile's own bodies and loads where it is not given"""
INDEXING_KEYS = (
    *DRIVE_KEYS,
    *(*INERTIA_KEYS, "contact_stiffness", "input_damping", "output_damping", "contact_damping", "cam_friction"),
    *("turret_friction", "cam_mass", "turret_mass", "load_mass", "cam_bending", "cam_axial", "turret_bending"),
    *("load_bending", "cross_bending", "output_axial", "exact_contact", "fluctuation", "fluctuation_order"),
    "estimate",
)
FOLLOWER_KEYS = (
    *("mass", "linkage_stiffness", "linkage_damping", "return_stiffness", "return_damping", "preload", "tappet_mass"),
    *("tappet_stiffness", "tappet_contact", "tappet_damping", "shaft_inertia", "shaft_stiffness", "shaft_damping"),
    "polydyne",
)


@final
class DynamicsSpec(Section):
    """Vibration of the elastic drive: an indexing drive (turret) or an elastic follower, by `kind`."""

    kind: Literal["indexing", "follower"] = Field(description="indexing: turret with load plate; follower: any other")
    method: Family | Gauss | Radau = Field(
        "auto", description="integrator; auto: gauss8, with the steps that the tolerance needs"
    )
    tolerance: Annotated[float, Field(ge=1e-13, le=0.1)] = Field(1e-6, description="share of the peak, by halving")
    steps: Annotated[int, Field(ge=1, le=4_000_000)] | None = Field(
        None, description="steps a turn; nothing is judged by them where their error is above 1 % of the peak; "
        "default: what the tolerance needs"
    )
    wilson_theta: Annotated[float, Field(ge=1.0, le=10.0)] = Field(1.40, description="of the wilson method")
    spectral_radius: Annotated[float, Field(ge=0.0, le=1.0)] = Field(0.8, description="of generalized-alpha")
    sweep: tuple[Speed, Speed] | None = Field(None, description="r/min, lowest and highest speed of a sweep")
    sweep_points: Annotated[int, Field(ge=2, le=5000)] = Field(100, description="speeds in the sweep")

    cam_inertia: Positive | None = Field(
        None, description="kg m2, cam with its share of the input shaft; default: the cam's body"
    )
    turret_inertia: Positive | None = Field(
        None, description="kg m2, turret; default: follower.inertia beside operation.load_inertia, what is left beside "
        "load_inertia, else its body"
    )
    load_inertia: Positive | None = Field(None, description="kg m2, load plate; default: the rest of what turns")
    input_stiffness: Positive | None = Field(None, description="N m/rad, input shaft in torsion")
    output_stiffness: Positive | None = Field(None, description="N m/rad, output shaft in torsion")
    contact_stiffness: Positive | None = Field(
        None, description="N m/rad at the turret, cam against rollers; default: Hertz line contact on the real flanks"
    )
    estimate: Literal["half-space", "secant", "chord"] = Field(
        "half-space",
        description="that default: half-space, the tangent about the load; secant, load over approach; chord, the "
        "secant of the source",
    )
    input_damping: NotNegative = Field(0.0, description="N m s/rad, input shaft")
    output_damping: NotNegative = Field(0.0, description="N m s/rad, output shaft")
    contact_damping: NotNegative = Field(0.0, description="N m s/rad at the turret, contact")
    cam_friction: NotNegative = Field(0.0, description="N m s/rad, viscous, on the cam")
    turret_friction: NotNegative = Field(0.0, description="N m s/rad, viscous, on the turret")
    cam_mass: NotNegative = Field(0.0, description="kg; 0 leaves the cam's lateral modes out")
    turret_mass: NotNegative = Field(0.0, description="kg; 0 leaves the output shaft's lateral modes out")
    load_mass: NotNegative = Field(0.0, description="kg, load plate")
    cam_bending: NotNegative = Field(0.0, description="N/mm, cam across its shaft, x and z")
    cam_axial: NotNegative = Field(0.0, description="N/mm, cam along its shaft, y")
    turret_bending: NotNegative = Field(0.0, description="N/mm, K22 of the output shaft")
    load_bending: NotNegative = Field(0.0, description="N/mm, K33 of the output shaft")
    cross_bending: Signed = Field(0.0, description="N/mm, K23 of the output shaft")
    output_axial: NotNegative = Field(0.0, description="N/mm, output shaft along its axis, z")
    exact_contact: bool = Field(False, description="motion taken at the wound-up cam angle (non-linear)")
    fluctuation: Annotated[float, Field(ge=0.0, lt=0.9)] = Field(0.0, description="share by which the speed swings")
    fluctuation_order: Annotated[int, Field(ge=1, le=1000)] = Field(1, description="swings of the speed in a turn")
    body_compliance: bool = Field(
        False, description="also what the cam's body gives way below the contact's own depth, from its volume mesh: in "
        "series with the rollers of a turret, with tappet_contact of a follower, or with its linkage at the cam angle "
        "where it is softest; all figures are those with it, rigid_body tells those without",
    )
    settling_band: Annotated[float, Field(gt=0.0, le=90.0)] = Field(
        0.005,
        description="deg (mm of a translating follower), band in which load plate or follower mass count as settled; "
        "what is not when its dwell ends fails where the band is given, and warns with the default: 0.005 deg of an "
        "indexing drive, 1 % of the stroke of a follower (what settles into that is told, not passed)",
    )

    mass: Positive | None = Field(
        None, description="kg (kg m2), beyond the linkage; default: the follower's mass and load without tappet_mass"
    )
    linkage_stiffness: Positive | None = Field(None, description="N/mm (N m/rad for swinging), cam to follower mass")
    linkage_damping: NotNegative = Field(0.0, description="N s/m (N m s/rad)")
    return_stiffness: NotNegative | None = Field(None, description="N/mm (N m/rad); default: operation.spring_rate")
    return_damping: NotNegative = Field(0.0, description="N s/m (N m s/rad), to ground")
    preload: NotNegative | None = Field(None, description="N (N m); default: operation.spring_preload")
    tappet_mass: NotNegative = Field(0.0, description="kg (kg m2), the part of the mass at the cam")
    tappet_stiffness: NotNegative = Field(0.0, description="N/mm (N m/rad), contact of the tappet; 0: rigid")
    tappet_contact: Literal["tangent", "secant"] | None = Field(
        None, description="tappet_stiffness from the contact itself, line, ellipse or half-space, where the roller is "
        "pressed hardest: tangent (for small vibration) or secant (from no load)"
    )
    tappet_damping: NotNegative = Field(0.0, description="N s/m (N m s/rad), contact of the tappet")
    shaft_inertia: Positive | None = Field(None, description="kg m2, cam on its elastic shaft")
    shaft_stiffness: Positive | None = Field(None, description="N m/rad, cam shaft in torsion; default: rigid")
    shaft_damping: NotNegative = Field(0.0, description="N m s/rad, cam shaft")
    polydyne: bool = Field(False, description="also the cam motion whose response at the speed is the wanted one")

    @field_validator("method", mode="before")
    @classmethod
    def _no_longer(cls, value: object) -> object:
        if value in LEFT:
            text = f"{value} is no longer offered: leave method out for the fastest, or take gauss4 with the same steps"
            raise ValueError(text)
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        idle = FOLLOWER_KEYS if self.kind == "indexing" else INDEXING_KEYS
        strange = [key for key in idle if key in self.model_fields_set]
        if strange:
            raise ValueError(f"{', '.join(strange)} mean nothing for kind = {self.kind!r}")
        needed = DRIVE_KEYS if self.kind == "indexing" else ("linkage_stiffness",)
        missing = [key for key in needed if getattr(self, key) is None]
        if missing:
            raise ValueError(f"kind = {self.kind!r} needs {', '.join(missing)}")
        if self.tappet_stiffness > 0.0 and self.tappet_contact is not None:
            raise ValueError("tappet_stiffness is given: leave it or tappet_contact out")
        if self.elastic_tappet and self.tappet_mass == 0.0:
            raise ValueError(f"{'tappet_contact' if self.tappet_contact else 'tappet_stiffness'} needs a tappet_mass")
        if self.shaft_inertia is not None and self.tappet_mass > 0.0 and not self.elastic_tappet:
            raise ValueError("with an elastic cam shaft a tappet_mass needs a tappet_stiffness")
        if self.body_compliance and self.estimate == "chord":
            raise ValueError("body_compliance begins below the contact's own depth, and estimate = 'chord' has none")
        if self.body_compliance and self.tappet_mass > 0.0 and self.tappet_contact is None:
            raise ValueError("with body_compliance a tappet_mass stands on the body, which needs its tappet_contact")
        if self.sweep is not None and self.sweep[0] >= self.sweep[1]:
            raise ValueError("sweep must rise from its first speed to its second")
        return self

    @property
    def elastic_tappet(self) -> bool:
        """Whether the tappet's contact with the cam yields."""
        return bool(self.tappet_stiffness or self.tappet_contact)

    def idle(self) -> dict[str, str]:
        """The keys that nothing reads, each with the reason."""
        found = {}
        if self.method != "wilson":
            found["wilson_theta"] = "only method = 'wilson' has it"
        if self.method != "generalized-alpha":
            found["spectral_radius"] = "only method = 'generalized-alpha' has it"
        if self.steps is not None:
            found["tolerance"] = "`steps` fixes the steps, whatever their error"
        if self.sweep is None:
            found["sweep_points"] = "there is no sweep"
        if self.contact_stiffness is not None:
            found["estimate"] = "contact_stiffness is given, nothing is estimated"
            found["body_compliance"] = "contact_stiffness is given: how much of the body it holds is not known"
        if not self.fluctuation:
            found["fluctuation_order"] = "the speed does not swing without a fluctuation"
        if not self.cam_mass:
            found |= dict.fromkeys(("cam_bending", "cam_axial"), "without a cam_mass the cam has no lateral modes")
        if not self.turret_mass:
            found["turret_bending"] = "without a turret_mass the turret has no lateral modes"
        if not self.load_mass:
            found["load_bending"] = "without a load_mass the load plate has no lateral modes"
        if not (self.turret_mass and self.load_mass):
            found["cross_bending"] = "couples the lateral modes of turret_mass and load_mass"
        if not (self.turret_mass or self.load_mass):
            found["output_axial"] = "without a turret_mass or load_mass nothing moves along the output shaft"
        if not self.elastic_tappet:
            found["tappet_damping"] = "a tappet without a tappet_stiffness is rigid"
        if self.shaft_stiffness is None:
            found["shaft_damping"] = "a cam shaft without a shaft_stiffness is rigid"
        return found

    def accuracy(self) -> Accuracy:
        """Method, tolerance (share of the peak) and steps."""
        from camgeom.dynamics.linear.accuracy import Accuracy
        from camgeom.dynamics.linear.method import generalized_alpha, wilson

        method: str | Method = self.method
        if self.method == "wilson":
            method = wilson(self.wilson_theta)
        elif self.method == "generalized-alpha":
            method = generalized_alpha(self.spectral_radius)
        return Accuracy(self.tolerance, method, self.steps)

    def speeds(self) -> np.ndarray[tuple[int], np.dtype[np.float64]] | None:
        """Speeds of the sweep in rad/s, None when no sweep is asked for."""
        if self.sweep is None:
            return None
        return np.linspace(*self.sweep, self.sweep_points) * np.pi / 30.0

    def speed_fluctuation(self) -> Fluctuation:
        """Fluctuation of the input speed."""
        from camgeom.dynamics.indexing.system import Fluctuation

        return Fluctuation(((self.fluctuation_order, self.fluctuation, 0.0),) if self.fluctuation > 0.0 else ())

    def drive(self, contact_table: tuple[float, ...] = (), inertias: Mapping[str, float] = NOTHING) -> IndexingDrive:
        """The indexing drive in SI; contact_table (N m/rad at equal steps of a turn) and inertias (kg m2, by
        INERTIA_KEYS) serve where the table gives none.

        Raises ProfileError when there is neither.
        """
        from camgeom.dynamics.indexing.drive import IndexingDrive

        missing = [key for key in INERTIA_KEYS if getattr(self, key) is None and key not in inertias]
        if missing:
            raise ProfileError([Problem(f"dynamics.{key}", "is missing", None, "> 0 kg m2") for key in missing])
        cam, turret, load = (getattr(self, key) or inertias[key] for key in INERTIA_KEYS)
        contact = self.contact_stiffness
        if contact is None:
            if not contact_table:
                hint = "or a load and elastic materials from which it follows"
                raise ProfileError([Problem("dynamics.contact_stiffness", "is missing", None, "> 0 N m/rad", hint)])
            contact = float(np.mean(contact_table))
        return IndexingDrive(
            cam_inertia=cam,
            turret_inertia=turret,
            load_inertia=load,
            input_stiffness=self.input_stiffness or 0.0,
            output_stiffness=self.output_stiffness or 0.0,
            contact_stiffness=contact,
            contact_table=contact_table if self.contact_stiffness is None else (),
            input_damping=self.input_damping,
            output_damping=self.output_damping,
            contact_damping=self.contact_damping,
            cam_friction=self.cam_friction,
            turret_friction=self.turret_friction,
            cam_mass=self.cam_mass,
            turret_mass=self.turret_mass,
            load_mass=self.load_mass,
            cam_bending_x=self.cam_bending * PER_MM,
            cam_bending_z=self.cam_bending * PER_MM,
            cam_axial_y=self.cam_axial * PER_MM,
            turret_bending=self.turret_bending * PER_MM,
            load_bending=self.load_bending * PER_MM,
            cross_bending=self.cross_bending * PER_MM,
            output_axial=self.output_axial * PER_MM,
        )

    def train(
        self,
        rotating: bool,
        closure: Closure = "force",
        mass: float = 0.0,
        return_stiffness: float = 0.0,
        preload: float = 0.0,
    ) -> FollowerTrain:
        """The elastic follower in SI; mass (kg or kg m2), return_stiffness (N/m or N m/rad), preload (N or N m) by
        default.
        """
        from camgeom.dynamics.follower.train import FollowerTrain

        per = 1.0 if rotating else PER_MM
        own = return_stiffness if self.return_stiffness is None else self.return_stiffness * per
        if self.mass is None and 0.0 < mass <= self.tappet_mass:
            text = "is all that moves (follower.mass and operation.load_mass) or more"
            hint = "give dynamics.mass for what is beyond the linkage"
            raise ProfileError([Problem("dynamics.tappet_mass", text, self.tappet_mass, f"< {mass:g}", hint)])
        return FollowerTrain(
            mass=mass - self.tappet_mass if self.mass is None else self.mass,
            stiffness=(self.linkage_stiffness or 0.0) * per,
            damping=self.linkage_damping,
            return_stiffness=own,
            return_damping=self.return_damping,
            preload=preload if self.preload is None else self.preload,
            tappet_mass=self.tappet_mass,
            contact_stiffness=self.tappet_stiffness * per,
            contact_damping=self.tappet_damping,
            closure=closure,
        )

    def shaft(self) -> CamShaft | None:
        """The elastic cam shaft, None where it is rigid."""
        from camgeom.dynamics.follower.train import CamShaft

        if self.shaft_inertia is None or self.shaft_stiffness is None:
            return None
        return CamShaft(inertia=self.shaft_inertia, stiffness=self.shaft_stiffness, damping=self.shaft_damping)
