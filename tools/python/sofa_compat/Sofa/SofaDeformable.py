# SPDX-License-Identifier: LGPL-2.1-or-later
"""Springs as scenes write them into the attribute `spring` of a SpringForceField."""


class LinearSpring(tuple):
    """One spring: two indices, stiffness, damping, length at rest."""

    def __new__(cls, index1=0, index2=0, springStiffness=0.0, dampingFactor=0.0, restLength=0.0):
        return super().__new__(cls, (index1, index2, springStiffness, dampingFactor, restLength))

    index1, index2, springStiffness, dampingFactor, restLength = (
        property(lambda self, at=at: tuple.__getitem__(self, at)) for at in range(5))
