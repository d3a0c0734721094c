# SPDX-License-Identifier: LGPL-2.1-or-later
"""What programs name of the extension: what steps and runs return."""
from typing import Any, List

import numpy

class StepReport:
    """What a step did."""

    diverged: bool
    stopped: bool
    unsolved: bool
    reason: str
    newton_iterations: int
    linear_iterations: int
    factorisations: int
    solve_seconds: float
    linear_residual: float
    linear_converged: bool
    newton_residual: float
    newton_converged: bool
    constraints_converged: bool
    constraint_reason: str

class RunReport:
    """How a run ended."""

    end: str
    last: StepReport
    reason: str
    seconds: float
    steps: int
    step_ms: numpy.ndarray[Any, Any]
    linear_iterations: int
    newton_iterations: int
    factorisations: int
    warnings: List[str]

def __getattr__(name: str) -> Any: ...
