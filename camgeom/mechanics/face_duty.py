"""Force, torque and contact stress of a planar cam round the turn; contact lost, the spring that keeps it, its speed.

A force-closed cam only pushes: where the follower would have to be pulled the contact is lost, and from there on the
follower does not run as the motion says. A form-closed cam has a second touch that takes over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, inf, isfinite, pi
from typing import Any, final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, hardest
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import highest, roots
from camgeom.mechanics.contact import Contact, line_contacts
from camgeom.mechanics.duty import finite, hertz_data, largest_of, peak_of, torque_data
from camgeom.mechanics.hertz import Beneath, beneath_line, line_depth
from camgeom.mechanics.life import cam_life, check_strength, hours, swept_damage
from camgeom.mechanics.load import QUIET, FollowerForce, Load, guided_force
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.track import Swing
from camgeom.track.touch import Touch

ROUNDS = 60
FINE = 7200
"""cam angles at which the damage along a face is summed: twentieths of a degree"""


@dataclass(frozen=True)
class Lost:
    """A range of cam angle (rad, end may pass the turn) without contact, with the largest missing force N and where."""

    begin: float
    end: float
    missing: float
    cam_angle: float


@final
@dataclass(frozen=True, eq=False)
class FaceDuty:
    """A planar cam under load over one turn: its touches, what acts on the follower, and the two materials."""

    touches: tuple[Touch, ...]
    load: Load
    follower: Material
    cam: Material

    @property
    def form_closed(self) -> bool:
        """True where a second touch drives the follower back."""
        return {touch.way for touch in self.touches} == {1.0, -1.0}

    @cached_property
    def force(self) -> FollowerForce:
        """Motion and force (N, or N mm about the pivot) that the follower needs, with a panel edge at every zero."""
        full = self.load.sampled()
        zeros = roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]
        if not zeros.size:
            return full
        return self.load.sampled(full.panels.split(zeros))

    @cached_property
    def _levers(self) -> list[Floats]:
        """Signed lever of every touch on the panels, (p, n)."""
        theta = self.force.panels.theta
        return [touch.at(theta.ravel()).lever.reshape(theta.shape) for touch in self.touches]

    @cached_property
    def normals(self) -> dict[str, Floats]:
        """Normal force of every touch, N, (p, n): zero where it does not carry."""
        levers = zip(self.touches, self._levers)
        return {touch.name: np.abs(self._given(touch, lever) / lever) for touch, lever in levers}

    def _given(self, touch: Touch, lever: Floats) -> Floats:
        """Force along the motion that a touch gives, N (N mm), (p, n), with the friction of a slide's guides.

        A slide's lever is the cosine of its pressure angle: the guides take the thrust across the motion.
        """
        force = np.maximum(touch.way * self.force.force, 0.0) * touch.way
        cosine = np.minimum(np.abs(lever), 1.0)
        return guided_force(force, cosine, self.load.guide_friction, self.force.direction)

    @cached_property
    def torque(self) -> Floats:
        """Torque that the cam takes from its shaft, N mm, (p, n); a lost contact takes none."""
        given = sum(self._given(touch, lever) for touch, lever in zip(self.touches, self._levers))
        return np.asarray(given * self.force.ds)

    @cached_property
    def least_force(self) -> Extreme | None:
        """Least normal force, N, guides included; negative where the follower must be pulled: contact is lost.

        Of a force-closed cam; None of a form-closed one, which has no such limit.
        """
        if self.form_closed:
            return None
        lever, force = self._levers[0], self.force.force
        pressed = np.where(force > 0.0, self._given(self.touches[0], lever), force)
        pull = peak_of(self.force.panels, -pressed / lever)
        return Extreme(-pull.value, pull.cam_angle, where=self.touches[0].name)

    @cached_property
    def lost(self) -> tuple[Lost, ...]:
        """Ranges of cam angle where a force-closed cam loses its follower."""
        least = self.least_force
        if least is None or least.value >= 0.0:
            return ()
        where, force = self.force.panels, self.force.force
        bad = force.mean(axis=-1) < 0.0
        if bad.all():
            return (Lost(0.0, 2.0 * pi, -least.value, least.cam_angle),)
        ranges = []
        begins = np.flatnonzero(bad & ~np.roll(bad, 1))
        for first in begins:
            count = int(np.argmin(np.roll(bad, -first)))
            index = (first + np.arange(count)) % len(bad)
            pull = np.where(np.isin(np.arange(len(bad)), index)[:, None], -force / self._levers[0], -inf)[index]
            part = np.unravel_index(int(np.argmax(pull)), pull.shape)
            last = int(index[-1])
            end = float(where.edges[last + 1]) + (2.0 * pi if last < first else 0.0)
            at = float(where.theta[index][part])
            ranges.append(Lost(float(where.edges[first]), end, float(pull[part]), at))
        return tuple(ranges)

    @cached_property
    def _relative(self) -> dict[str, Floats]:
        """Relative curvature at every touch, 1/mm, (p, n); a knife edge has none."""
        theta = self.force.panels.theta
        return {
            touch.name: np.clip(touch.at(theta.ravel()).relative, -1e12, 1e12).reshape(theta.shape)
            for touch in self.touches
            if touch.kind != "knife"
        }

    @cached_property
    def contacts(self) -> dict[str, Contact]:
        """Hertz line contact of every touch; a knife edge has none."""
        pair = pair_compliance(self.follower, self.cam)
        theta, found = self.force.panels.theta, {}
        for touch in self.touches:
            if touch.kind == "knife":
                continue
            at = touch.at(theta.ravel())
            k = self._relative[touch.name]
            zero = np.zeros(theta.shape)
            normal = self.normals[touch.name]
            slip = at.sliding.reshape(theta.shape)
            found[touch.name] = line_contacts(self.force.panels, normal, k, zero, slip, touch.length, pair)
        return found

    @cached_property
    def peak_pressure(self) -> Extreme | None:
        """Largest contact pressure, MPa, and the touch that has it; None for a knife edge."""
        peaks = [(name, contact.peak()) for name, contact in self.contacts.items()]
        if not peaks:
            return None
        name, worst = max(peaks, key=lambda item: float(item[1].pressure))
        return Extreme(float(worst.pressure), float(worst.theta), where=name)

    @cached_property
    def contact_forces(self) -> Floats:
        """Normal force of every touch, N, (k, p, n)."""
        return np.stack(list(self.normals.values()))

    @cached_property
    def peak_force(self) -> Extreme:
        """Largest normal force of a touch, N."""
        return peak_of(self.force.panels, self.contact_forces.max(axis=0))

    @cached_property
    def peak_torque(self) -> Extreme:
        """Largest torque that the cam takes from its shaft or gives it, N mm, as a magnitude."""
        return largest_of(self.force.panels, self.torque)

    @cached_property
    def work(self) -> float:
        """Work of the cam over a turn, N mm: what friction, the guides' too, and applied forces consume."""
        return float(self.force.panels.integral(self.torque))

    @cached_property
    def peak_contact(self) -> Beneath | None:
        """Half-width and subsurface shear of the hardest contact; None of a knife edge and where a wall is undercut."""
        peak = self.peak_pressure
        if peak is None or not isfinite(peak.value):
            return None
        touch = next(one for one in self.touches if one.name == peak.where)
        k = float(touch.at(np.array([peak.cam_angle])).relative[0])
        return beneath_line(peak.value, k, pair_compliance(self.follower, self.cam)) if k > 0.0 else None

    @property
    def unheld(self) -> Extreme | None:
        """None: only the groove of a drum runs out."""
        return None

    @cached_property
    def deepest_shear(self) -> Extreme | None:
        """Where the largest shear lies deepest over the turn, mm; None of a knife edge and of a wall undercut."""
        if not self.contacts or not all(np.all(contact.sound) for contact in self.contacts.values()):
            return None
        pair, found = pair_compliance(self.follower, self.cam), []
        for name, contact in self.contacts.items():
            k = self._relative[name]
            depths = line_depth(contact.pressure, np.where(k > 0.0, k, 1.0), pair)
            found.append(replace(peak_of(self.force.panels, depths), where=name))
        return hardest(found)

    def spot(self, at: Extreme) -> str:
        """The touch, and its length."""
        length = next((touch.length for touch in self.touches if touch.name == at.where), self.touches[0].length)
        return f"{at.where}, {length:.4g} mm touch"

    @cached_property
    def lives(self) -> dict[str, float]:
        """Contact fatigue life, h, of the cam's hardest point and of the face's; empty of a knife edge.

        A sliding face wears besides, which no fatigue law tells. A cam point that two faces meet sums their damage,
        the face's that of every pass of the contact over its hardest point.
        """
        if not self.contacts:
            return {}
        if not all(np.all(contact.sound) for contact in self.contacts.values()):
            return {"cam": 0.0, "face": 0.0}
        omega, contacts = self.load.omega, self.contacts.values()
        cam, face = (
            max(float(cam_life(contact, material, omega).damage) for contact in contacts)
            for material in (self.cam, self.follower)
        )
        turn = np.linspace(0.0, 2.0 * pi, FINE, endpoint=False)
        for outline in {touch.outline for touch in self.touches}:
            meeting = [touch for touch in self.touches if touch.outline == outline]
            if len(meeting) > 1:
                each = np.stack([self._damage(touch, turn - touch.lag, self.cam) for touch in meeting])
                cam = max(cam, float(each.sum(axis=0).max()))
        for touch in self.touches:
            face = max(face, swept_damage(_face_place(touch, turn), self._damage(touch, turn, self.follower)))
        return {"cam": float(hours(cam, omega)), "face": float(hours(face, omega))}

    def _damage(self, touch: Touch, theta: Floats, material: Material) -> Floats:
        """Damage, (n,), of a material by one contact with a touch at cam angles (n,), rad."""
        contact = self.contacts[touch.name]
        check_strength(contact.pressure, material)
        square = np.maximum(self.force.panels.at(contact.behind, np.mod(theta, 2.0 * pi)), 0.0)
        return np.asarray((square / material.contact_limit**2) ** (0.5 * material.exponent) / material.contact_cycles)

    @property
    def bearing(self) -> None:
        """None: a roller's bearing is judged with its roller (`roller_duty`)."""

    @cached_property
    def preload_needed(self) -> float:
        """Least spring force at zero lift that keeps contact at the given rate and speed, N (N mm)."""
        rest = float(np.asarray(self.load.preload))
        value, _ = highest(self.force.panels, rest - self.force.force)
        return max(0.0, float(value))

    @cached_property
    def rate_needed(self) -> float:
        """Least spring rate that keeps contact at the given preload, N/mm (N mm/rad); inf where none does.

        At zero lift the spring has its preload whatever its rate, so a force that is missing there asks for preload.
        """
        where, lift = self.force.panels, self.force.lift
        rate = float(np.asarray(self.load.rate))
        without = self.force.force - rate * lift
        small = 1e-9 * float(np.abs(lift).max(initial=0.0))
        if np.any((without < 0.0) & (lift <= small)):
            return inf
        if not np.any(without < 0.0):
            return 0.0
        # The ratio is smooth where the force is missing; elsewhere only its sign matters.
        safe = np.where(lift > small, lift, 1.0)
        value, _ = highest(where, np.where(without < 0.0, -without / safe, 0.0))
        return float(value)

    @cached_property
    def leaving_speed(self) -> float:
        """Cam speed, rad/s, from which the follower leaves a force-closed cam; inf where it never does.

        Contact needs static + omega² m s'' >= 0, so omega² = 1 / max(-m s'' / static). Forces that hang on the speed
        are followed by repeating. 0 where contact fails at standstill. Raises NotConverged where that does not settle.
        """
        if self.form_closed:
            return inf
        speed = self.load.omega
        for _ in range(ROUNDS):
            new = self._leaving(replace(self.load, speed=speed))
            if not isfinite(new) or new == 0.0 or abs(new - speed) <= 1e-12 * new:
                return new
            speed = new
        raise NotConverged("the speed at which contact is lost did not settle: the applied forces hang on the speed")

    @staticmethod
    def _leaving(load: Load) -> float:
        found = load.sampled()
        speed = load.omega
        static = found.force - found.inertia
        if static.min() <= 0.0:
            return 0.0
        share, _ = highest(found.panels, -found.inertia / static)
        return speed / float(np.sqrt(share)) if share > 0.0 else inf

    def torque_data(self) -> dict[str, Any]:
        """Torque of the camshaft over all touches as plain data."""
        return torque_data(self.peak_torque, self.work)

    def contact_data(self) -> dict[str, Any]:
        """Force, torque, pressure, and what keeps the contact, as plain data for result.json."""
        data: dict[str, Any] = {"peak_force_n": self.peak_force.value, **self.torque_data()}
        peak, least = self.peak_pressure, self.least_force
        if peak is not None:
            place = {"cam_angle_deg": degrees(peak.cam_angle) % 360.0, "peak_at": peak.where}
            data |= {"peak_pressure_mpa": finite(peak.value), **place}
            data |= hertz_data(self.peak_contact, self.deepest_shear)
        if least is None:
            return data
        return data | {
            "least_force_n": least.value,
            "least_force_at_deg": degrees(least.cam_angle) % 360.0,
            "lost_contact_deg": [[degrees(lost.begin), degrees(lost.end)] for lost in self.lost],
            "leaving_speed_rpm": finite(self.leaving_speed * 30.0 / pi),
            "preload_needed": self.preload_needed,
        }

    def fatigue_data(self) -> dict[str, Any]:
        """Lives of cam and face as plain data; empty of a knife edge."""
        return {f"{body}_life_h": finite(life) for body, life in self.lives.items()}


def _face_place(touch: Touch, phi: Floats) -> Floats:
    """Place of the contact on the follower's face, mm along it, at cam angles (n,): on a curved one along its arc."""
    at = touch.at(phi)
    if touch.kind == "flat":
        return at.along
    if not isinstance(touch.joint, Swing):
        return np.asarray(touch.radius * at.pressure_angle)
    pivot = complex(*touch.joint.centre[:2]) * np.exp(-1j * touch.sense * phi)
    normal = at.curve.normals[0] + 1j * at.curve.normals[1]
    arm = at.curve.points[0] + 1j * at.curve.points[1] + touch.material * touch.radius * normal - pivot
    return np.asarray(touch.radius * np.unwrap(np.angle(normal / arm)))
