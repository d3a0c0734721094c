# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pictures and films of a simulation, drawn without a display. Jupyter shows them below the cell."""
import operator
import os
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

from . import _stroma
from .errors import StepError
from .types import nearest

if TYPE_CHECKING:
    from .simulation import Simulation

_AXES = {"x": 0, "y": 1, "z": 2}
_WORDS = ("field", "colours", "title", "edges", "flat", "ghost", "shaded", "transparent", "legend", "bare")
_OTHERS = ("range", "views", "size", "cut", "exaggerate", "hide", "frame")


class Picture:
    """A PNG file in memory; of a film an animated one, which browsers play."""

    def __init__(self, png: bytes, summary: str, notes: Sequence[str]):
        self.png = png  #: the bytes of the file
        self.summary = summary  #: what the colours mean, and their range
        self.notes: List[str] = list(notes)  #: what one does not see, as a body that is too small

    def save(self, file: Union[str, os.PathLike]) -> None:
        """Writes the PNG file."""
        with open(file, "wb") as opened:
            opened.write(self.png)

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        return f"<picture: {self.summary}, {len(self.png) / 1000:.0f} kB>"


def _texts(given: Any) -> List[str]:
    """One or several of them. A view may be (azimuth, elevation) in degrees."""
    if isinstance(given, str):
        return [given]
    if len(given) == 2 and all(isinstance(each, (int, float)) for each in given):
        given = [given]
    return [each if isinstance(each, str) else ",".join(f"{angle:g}" for angle in each) for each in given]


def _cut(given: Union[str, Tuple[Any, ...]]) -> Tuple[int, float, str]:
    """("x", 0.02), ("x", 0.02, "below") or "x=0.02,below"."""
    words = given.replace("=", ",").split(",") if isinstance(given, str) else list(given)
    kept = str(words[2]).strip() if len(words) == 3 else ""
    axis = str(words[0]).strip() if words else ""
    if len(words) not in (2, 3) or axis not in _AXES or kept not in ("", "below", "above"):
        raise ValueError(f"no cut is {given!r}: expected (\"x\", 0.02), perhaps with \"below\" or \"above\" behind it")
    return _AXES[axis], float(words[1]), kept


def _size(given: Any) -> Tuple[int, int]:
    try:
        width, height = map(operator.index, given)
    except (TypeError, ValueError):
        width = height = 0
    if min(width, height) < 1:
        raise ValueError(f"no picture has the size {given!r}: expected (width, height) in pixels, two whole numbers above 0")
    return width, height


def _request(look: Dict[str, Any]) -> Any:
    request = _stroma.PictureRequest()
    for name, value in look.items():
        if name not in _WORDS + _OTHERS:
            near = nearest(name, _WORDS + _OTHERS)
            raise TypeError(f"a picture has no '{name}'" + (f"; did you mean '{near}'?" if near else f": it has {', '.join(_WORDS + _OTHERS)}"))
        if value is None:
            continue
        if name == "range":
            low, high = map(float, value)
            if not low < high:
                raise ValueError(f"the colours cannot go from {low:g} to {high:g}: expected (low, high)")
            request.set_range(low, high)
        elif name == "size":
            request.width, request.height = _size(value)
        elif name == "cut":
            request.set_cut(_cut(value))
        elif name in _WORDS:
            setattr(request, name, value)
        elif name == "exaggerate":
            request.exaggeration = float(value)
        else:
            setattr(request, {"views": "views", "hide": "hidden", "frame": "framed"}[name], _texts(value))
    return request


def picture_of(simulation: "Simulation", look: Dict[str, Any]) -> Picture:
    camera = _stroma.Camera(simulation._engine)
    camera.begin(_request(look))
    camera.take()
    png = camera.still()  # which finds out what there is to say
    return Picture(png, camera.summary(), camera.notes())


def film_of(simulation: "Simulation", steps: Optional[int], until: Optional[float], every: int, fps: float, look: Dict[str, Any]) -> Picture:
    try:
        between = operator.index(every)
    except TypeError:
        between = 0
    if between < 1 or not fps > 0:
        raise ValueError(f"a film has a frame every {every} steps and {fps} frames a second: expected a whole number from 1 on, and fps above 0")
    camera = _stroma.Camera(simulation._engine)
    camera.begin(_request(look))
    camera.take()
    first = simulation.steps
    token = simulation.on_step_end(lambda sim: camera.take() if (sim.steps - first) % between == 0 else None)
    try:
        report = simulation.run(steps, until)
    finally:
        token.remove()
    if report.end != "done":
        raise StepError(report.reason or simulation.stop_reason, report)
    png = camera.film(float(fps))
    return Picture(png, camera.summary(), camera.notes())
