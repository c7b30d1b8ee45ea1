"""Force, torque and contact stress of a planar cam round the turn.

A force-closed cam only pushes (see `kept`); a form-closed cam has a second touch that takes over.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees, isfinite, pi
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, hardest
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, resolved, roots
from camgeom.mechanics.contact import Contact, line_contacts
from camgeom.mechanics.duty import Duty, finite, hertz_data, peak_of, torque_data
from camgeom.mechanics.hertz import Beneath, beneath_line, line_depth, line_half_width
from camgeom.mechanics.kept import Kept, zeroed
from camgeom.mechanics.life import cam_life, check_strength, hours, swept_damage
from camgeom.mechanics.load import FLAT, QUIET, FollowerForce, Load, guided_force
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.track import Swing
from camgeom.track.touch import Touch

if TYPE_CHECKING:
    from camgeom.mechanics.film import Film, Oil

CELLS, MOST_CELLS = 8, 20_000
"""into which half a width of the contact, and the whole way, are cut for wear"""
AT_ONCE = 200_000
"""cells that are filled at once: 1.6 MB an array"""
SHARP = 1e-7
"""share of the largest relative curvature to which it is resolved"""
FINE = 7200
"""cam angles at which the damage along a face is summed: twentieths of a degree"""


@final
@immutable
class FaceDuty(Duty):
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
        """Motion and force (N, or N mm about the pivot) that the follower needs, with a panel edge at every zero, on
        panels that resolve the curvature too: a profile about to fold is sharp over a small part of a degree."""
        full = zeroed(self.load)
        if self.load.guide_friction > 0.0 and (square := self._square(full.panels)).size:
            full = self.load.sampled(full.panels.split(square))
        if not self._curved:
            return full
        fine = resolved(self._curvatures, full.panels, SHARP)
        return full if len(fine.half) == len(full.panels.half) else self.load.sampled(fine)

    def _square(self, panels: Panels) -> Floats:
        """Cam angles, rad, at which a pressure angle passes zero: the thrust on a slide's guides has a kink there."""
        upright = [touch for touch in self.touches if touch.lean == 0.0]
        angles = [touch.at(panels.theta.ravel()).pressure_angle.reshape(panels.theta.shape) for touch in upright]
        return np.concatenate([*roots(panels, np.stack(angles), FLAT), []]) if angles else np.zeros(0)

    @cached_property
    def _curved(self) -> list[Touch]:
        """The touches that have a curvature: a knife edge has none."""
        return [touch for touch in self.touches if touch.kind != "knife"]

    def _curvatures(self, theta: Floats) -> Floats:
        """Relative curvature at every touch that has one, 1/mm, (k, p, n), kept finite where a profile folds."""
        each = [touch.at(theta.ravel()).relative.reshape(theta.shape) for touch in self._curved]
        return np.clip(np.stack(each), -1e12, 1e12)

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
    def kept(self) -> Kept | None:
        """What keeps the follower on a force-closed cam; None of a form-closed one, which has no such limit."""
        if self.form_closed:
            return None
        lever = self._levers[0]
        return Kept(self.load, self.force, lever, np.minimum(np.abs(lever), 1.0), self.touches[0].name)

    @cached_property
    def _relative(self) -> dict[str, Floats]:
        """Relative curvature at every touch, 1/mm, (p, n); a knife edge has none."""
        if not self._curved:
            return {}
        return dict(zip((touch.name for touch in self._curved), self._curvatures(self.force.panels.theta)))

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
    def least_peak(self) -> Extreme | None:
        """Largest contact pressure, MPa, and the touch that has it; None for a knife edge."""
        peaks = [(name, contact.peak()) for name, contact in self.contacts.items()]
        if not peaks:
            return None
        name, worst = max(peaks, key=lambda item: float(item[1].pressure))
        return Extreme(float(worst.pressure), float(worst.theta), where=name)

    @property
    def no_stress(self) -> str:
        """Of a knife edge."""
        return "" if self.contacts else "a knife edge has no contact pressure: give the follower a face with a radius"

    @cached_property
    def contact_forces(self) -> Floats:
        """Normal force of every touch, N, (k, p, n)."""
        return np.stack(list(self.normals.values()))

    @cached_property
    def peak_contact(self) -> Beneath | None:
        """Half-width and subsurface shear of the hardest contact; None of a knife edge and where a wall is undercut."""
        peak = self.peak_pressure
        if peak is None or not isfinite(peak.value):
            return None
        pressed = self.contacts[peak.where].pressure
        k = float(self.force.panels.limit(self._relative[peak.where], peak.cam_angle, pressed))
        return beneath_line(peak.value, k, pair_compliance(self.follower, self.cam)) if k > 0.0 else None

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

    def film(self, oil: Oil) -> Film | None:
        """The film of the thinnest of all touches; None of a knife edge and without any load."""
        from camgeom.mechanics.film import line_film, thinnest

        theta = self.force.panels.theta
        pair, ratio = pair_compliance(self.follower, self.cam), np.full(theta.shape, np.inf)
        which = np.zeros(theta.shape, dtype=np.intp)
        for number, touch in enumerate(self.touches):
            if touch.kind == "knife":
                return None
            speed = self.load.omega * touch.at(theta.ravel()).passing.reshape(theta.shape)
            normal, k = self.normals[touch.name], self._relative[touch.name]
            bears = (normal > QUIET * self.contact_forces.max()) & (k > 0.0)
            safe = np.where(bears, normal, 1.0) / touch.length
            each = np.where(bears, line_film(speed, np.where(bears, k, 1.0), safe, oil, pair) / oil.roughness, np.inf)
            which, ratio = np.where(each < ratio, number, which), np.minimum(ratio, each)
        return thinnest(theta, ratio, oil, where=lambda at: self.touches[int(which.flat[at])].name)

    @cached_property
    def rubbed(self) -> float:
        """Load times sliding way of all touches over a turn, N mm."""
        theta = self.force.panels.theta
        each = (self.normals[t.name] * t.at(theta.ravel()).sliding.reshape(theta.shape) for t in self.touches)
        return float(sum(self.force.panels.integral(one) for one in each))

    @cached_property
    def rubbing(self) -> dict[str, float]:
        """Load per width times sliding way that passes a point of cam and face, N/mm; see `Duty.rubbing`."""
        turn = np.linspace(0.0, 2.0 * pi, FINE, endpoint=False)
        step, most = turn[1], {"cam": 0.0, "face": 0.0}
        for touch in self.touches:
            if touch.kind == "knife":
                return {}
            at = touch.at(turn)
            load = np.maximum(self.force.panels.at(self.normals[touch.name], turn), 0.0) / touch.length
            half = line_half_width(load, np.where(at.relative > 0.0, at.relative, 1.0), self._compliance)
            work = load * at.sliding * step
            way = np.cumsum(np.abs(at.curve.speed)) * step
            most["cam"] += heaped(way, half, work, float(way[-1]))
            most["face"] = max(most["face"], heaped(_face_place(touch, turn), half, work))
        return most

    @property
    def _compliance(self) -> float:
        return pair_compliance(self.follower, self.cam)

    def torque_data(self) -> dict[str, Any]:
        """Torque of the camshaft over all touches as plain data."""
        return torque_data(self.peak_torque, self.work)

    def contact_data(self) -> dict[str, Any]:
        """Force, torque, pressure, and what keeps the contact, as plain data for result.json."""
        data, peak = self.force_data(), self.peak_pressure
        if peak is None:
            return data
        place = {"cam_angle_deg": degrees(peak.cam_angle) % 360.0, "peak_at": peak.where}
        return data | {"peak_pressure_mpa": finite(peak.value), **place} | hertz_data(
            self.peak_contact, self.deepest_shear)  # fmt: skip

    def force_data(self) -> dict[str, Any]:
        """Force, torque, and what keeps the contact, as plain data."""
        data: dict[str, Any] = {"peak_force_n": self.peak_force.value, **self.torque_data()}
        return data | (self.kept.data() if self.kept is not None else {})

    def fatigue_data(self) -> dict[str, Any]:
        """Lives of cam and face as plain data; empty of a knife edge."""
        return {f"{body}_life_h": finite(life) for body, life in self.lives.items()}


def heaped(place: Floats, half: Floats, work: Floats, around: float | None = None) -> float:
    """Largest sum of work, N, per length, mm, laid on a face round the turn: N/mm.

    place (n,): of the contact, mm; half (n,): its half width, mm, over which a step's work lies as the pressure does,
    in an ellipse; around: length after which the places come again.
    """
    reach = half + np.abs(np.gradient(place))
    low, high = float((place - reach).min()), float((place + reach).max())
    cells = max(1, min(MOST_CELLS, int(CELLS * (high - low) / max(float(np.median(half)), 1e-9))))
    edges = np.linspace(low, high, cells + 1)
    # A step moves on by as much as the contact is wide, or more: its work lies on that way too.
    heap, wide = np.zeros(cells), np.maximum(reach, (high - low) / cells)
    first = np.clip(np.searchsorted(edges, place - wide) - 1, 0, cells - 1)
    last = np.clip(np.searchsorted(edges, place + wide), 1, cells)
    for some in np.array_split(np.flatnonzero(work > 0.0), 1 + int((last - first).sum()) // AT_ONCE):
        count = last[some] - first[some] + 1
        start = np.cumsum(count) - count
        each, edge = np.repeat(some, count), np.arange(count.sum()) + np.repeat(first[some] - start, count)
        x = np.clip((edges[edge] - place[each]) / wide[each], -1.0, 1.0)
        # The part of an ellipse up to x.
        part = 0.5 + (np.arcsin(x) + x * np.sqrt(1.0 - x * x)) / pi
        within = each[1:] == each[:-1]
        laid = (work[each[1:]] * np.diff(part))[within]
        cell = edge[:-1][within]
        heap += np.bincount(cell, laid, cells)
    length = (high - low) / cells
    if around is not None and around < high - low:
        # A contact wider than all the way round lies on the same places several times.
        whole = max(1, round(around / length))
        folded, length = np.zeros(whole), min(length, around)
        np.add.at(folded, np.arange(cells) % whole, heap)
        heap = folded
    return float(heap.max() / length)


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
