# SPDX-License-Identifier: LGPL-2.1-or-later
"""A window of SOFA: scenes import it for Sofa.Gui, which opens the live view here."""
