"""What a command was asked for, product by product: each made, refused or failed for a reason of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal, TypeVar, final

from camgeom.errors import Unmade, unmade
from camgeom.immutable import immutable

Status = Literal["made", "not applicable", "refused", "failed"]
RANK: dict[Status, int] = {"made": 0, "not applicable": 1, "refused": 2, "failed": 3}
T = TypeVar("T")


@final
@immutable(eq=True)
class Product:
    """One product: a section of the result, a body, a section of the report, a format, a picture.

    status       "made"; "not applicable" where the cam or its profile has no such thing, which is known before anything
                 is computed; "refused" where the design admits none; "failed" where it could not be made
    reason       why it was not made; of what was made, what there is to know of it
    exit_status  what it means for the command: 0, or 1 to 3
    files        names of its files in the folder of the run
    trace        where an error of camgeom itself came from
    """

    name: str
    status: Status
    reason: str = ""
    exit_status: int = 0
    files: tuple[str, ...] = ()
    trace: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The product as plain data for result.json, what is empty left out."""
        data: dict[str, Any] = {"status": self.status, "reason": self.reason, "files": list(self.files)}
        data["trace"] = self.trace.splitlines()
        return {key: value for key, value in data.items() if value}


class Products:
    """The products of one command in the order in which they were tried; names of parts follow a dot, `png.section`.

    shown  how a reason is worded for the user: the place where a file is made is not where it will stand
    """

    def __init__(self, shown: Callable[[str], str] = lambda reason: reason) -> None:
        self._products: dict[str, Product] = {}
        self._shown = shown

    def __iter__(self) -> Iterator[Product]:
        return iter(self._products.values())

    def __contains__(self, name: str) -> bool:
        return name in self._products

    def __getitem__(self, name: str) -> Product:
        return self._products[name]

    def attempt(self, name: str, job: Callable[[], T], files: tuple[str, ...] = ()) -> T | None:
        """The outcome of a job, which makes the named files; None, and the reason noted, where it fails."""
        try:
            found = job()
        except Exception as error:
            self.unmade(name, unmade(error))
            return None
        self.note(Product(name, "made", files=files))
        return found

    def unmade(self, name: str, why: Unmade) -> None:
        """Note a product that could not be made."""
        self.note(Product(name, why.status, self._shown(why.reason), why.exit_status, trace=why.trace))

    def absent(self, name: str, reason: str, exit_status: int = 0) -> None:
        """Note a product that does not apply; exit status 1 where it was asked for by name."""
        self.note(Product(name, "not applicable", reason, exit_status))

    def note(self, product: Product) -> None:
        """Note a product."""
        self._products[product.name] = product

    def gather(self, name: str, whole: bool = True) -> None:
        """Note a product of parts, as good as the worst, with all their files; `whole`: there are no other parts."""
        parts = [product for product in self if product.name.startswith(f"{name}.")]
        worst = max(parts, key=lambda part: RANK[part.status])
        files = tuple(file for part in parts for file in part.files)
        status = max(part.exit_status for part in parts)
        lacking: dict[str, list[str]] = {}
        for part in parts:
            if part.status != "made":
                lacking.setdefault(part.reason, []).append(part.name.partition(".")[2])
        every = len(parts) if whole else -1
        told = (why if len(names) == every else f"{', '.join(names)}: {why}" for why, names in lacking.items())
        reason = "; ".join(told)
        self.note(Product(name, worst.status, reason, status, files))

    @property
    def exit_status(self) -> int:
        """The worst."""
        return max((product.exit_status for product in self), default=0)

    def as_dict(self) -> dict[str, dict[str, Any]]:
        """All products as plain data for result.json, by name."""
        return {product.name: product.as_dict() for product in self}
