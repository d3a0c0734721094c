# SPDX-License-Identifier: LGPL-2.1-or-later
"""SOFA binds classes of SofaBaseLinearSolver here; scenes import it for what their objects answer, which they do without it."""
