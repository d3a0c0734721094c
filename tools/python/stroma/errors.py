# SPDX-License-Identifier: LGPL-2.1-or-later
"""What goes wrong, as exceptions. All of them are StromaError."""
from typing import Any, List, NamedTuple, Sequence, Union


class Problem(NamedTuple):
    """One finding about a scene."""

    severity: str  #: "error", "warning" or "note"
    file: str
    line: int
    column: int
    path: str  #: in the tree: "/liver/fem.method"
    message: str
    expected: str
    suggestion: str  #: the nearest right name, or the fix
    text: str  #: all of it, as `stroma check` prints it


class StromaError(RuntimeError):
    """Everything that Stroma refuses or that fails in it."""


class SceneError(StromaError):
    """A scene, or a change of one, that cannot be. `problems` has every one found; file, line, path and nearest are those of
    the first."""

    def __init__(self, problems: Union[str, Sequence[Any]]):
        if isinstance(problems, str):
            problems = [("error", "", 0, 0, "", problems, "", "", problems)]
        self.problems: List[Problem] = [Problem(*problem) for problem in problems]
        wrong = [problem for problem in self.problems if problem.severity == "error"]
        first = (wrong or self.problems or [Problem("error", "", 0, 0, "", "", "", "", "")])[0]
        self.file, self.line, self.path, self.nearest = first.file, first.line, first.path, first.suggestion
        super().__init__("\n".join(problem.text for problem in wrong or self.problems))

    def __reduce__(self):
        return type(self), (self.problems,)


class LoadNeeded(SceneError):
    """The change of a running scene that only another load makes."""


class StepError(StromaError):
    """A step without a result. `report` is that of the step or the run; the states are those of the last good step."""

    def __init__(self, reason: str, report: Any = None):
        self.report = report
        super().__init__(reason)

    def __reduce__(self):  # a report belongs to its process
        return type(self), (str(self),)


class SceneWarning(UserWarning):
    """A scene or a run that may not be what was meant: what the command prints as "warning"."""


class OutputError(StromaError):
    """A file could not be written."""


def refusal(message: str, expected: str = "", nearest: str = "", where=("", 0), path: str = "") -> SceneError:
    """A SceneError of one problem, told as the engine tells its own."""
    file, line = where
    meant = nearest if " " in nearest or not nearest else f"did you mean '{nearest}'?"  # advice, or a name
    hints = [hint for hint in ((f"expected {expected}" if expected else ""), meant) if hint]
    head = "".join(part + ": " for part in (f"{file}:{line}" if file else "", "error", path) if part)
    text = head + message + (f" ({'; '.join(hints)})" if hints else "")
    return SceneError([("error", file, line, 0, path, message, expected, nearest, text)])
