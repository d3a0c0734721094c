# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tables 1 to 3 of Nesme et al. 2005 (truth cube) as printed, and what is said above ours."""
from collections import namedtuple

# model: (element, method, B updated, V updated); printed: (mean, min, max, standard deviation) [%] at 5, 12.5 and 18.25 %
Row = namedtuple("Row", "name model printed ms")

ROWS = [
    Row("tets, linear", ("tets", "small", 0, 0), ((1.06, .09, 2.92, .62), (1.53, .08, 4.38, .88), (2.08, .27, 5.32, 1.03)), 40),
    Row("tets, QR, no B", ("tets", "large", 0, 0), ((1.04, .09, 2.9, .61), (1.42, .11, 4.16, .82), (1.69, .1, 4.78, .94)), 57),
    Row("tets, QR, B", ("tets", "large", 1, 0), ((1.06, .06, 2.89, .59), (1.54, .2, 4.24, .77), (2.13, .64, 5.39, .91)), 58),
    Row("tets, polar, no B", ("tets", "polar", 0, 0), ((1.06, .08, 2.92, .62), (1.56, .13, 4.43, .88), (2.24, .44, 5.37, 1.05)), 75),
    Row("tets, polar, B", ("tets", "polar", 1, 0), ((1.05, .09, 2.88, .61), (1.44, .11, 3.89, .79), (1.77, .15, 4.25, .88)), 80),
    Row("tets, polar, B and V", ("tets", "polar", 1, 1), ((1.06, .08, 2.85, .6), (1.46, .12, 3.78, .77), (1.81, .18, 3.96, .84)), 81),
    Row("tets, svd, B", ("tets", "svd", 1, 0), None, None),
    Row("tets, Green-Lagrange", ("tets", "green", 0, 0), None, None),
    Row("hexes, QR, B", ("hexes", "large", 1, 0), ((1.05, .09, 2.88, .61), (1.44, .09, 3.9, .8), (1.76, .09, 4.36, .92)), 150),
    Row("hexes, polar, no B", ("hexes", "polar", 0, 0), ((1.65, .08, 3.66, .79), (3.27, .44, 6.83, 1.39), (4.97, .91, 9.57, 1.89)), 24),
    Row("hexes, polar, B", ("hexes", "polar", 1, 0), ((1.06, .09, 2.88, .6), (1.47, .09, 3.87, .78), (1.82, .14, 4.16, .87)), 150),
    Row("hexes, small deformation (Ansys)", ("hexes", "small", 0, 0), ((1.07, .03, 2.94, .63), (1.49, .1, 4.29, .87), (1.97, .44, 5.18, 1.)), None),
    Row("hexes, large deformation (Ansys)", ("hexes", "green", 0, 0), ((1.06, .04, 2.93, .63), (1.45, .05, 4.12, .83), (1.78, .2, 4.83, .91)), None),
    Row("Phymul", ("Phymul", None, 0, 0), ((1.19, .19, 3.3, .54), (1.98, .34, 5.52, .88), (2.69, .33, 6.72, 1.16)), 12),
    Row("Phymul, volume free", ("Phymul, volume free", None, 0, 0), None, None),
]

INTRODUCTION = """Relative deviation in percent of 80 mm, 343 beads. 14.9 kPa, 980 kg/m3, 8 x 8 x 8 cells of 10 mm. Base and top are
glued. The plate reaches 4, 10 and 14.6 mm within one second each and rests for two; then the cube is measured. The printed
Poisson's ratio is 0.499. "Remark" says when the body was not at rest, rested in another shape than the converged one, or
flew apart. Such a row has no answer with these settings. "Mean dilatation" is the attribute `dilatation="mean"` of the force
fields: the volume change is one number per hexahedron, or one around a node of tetrahedra. What moves the numbers is measured
in the last table.
"""

# What the tables are made for: name, Poisson's ratio, `dilatation`
BODIES = (("0.499", "0.499", "local"), ("0.499 and mean dilatation", "0.499", "mean"), ("0.48", "0.48", "local"))


def has_mean_dilatation(row):
    """Phymul has no elements; Green's strain has the mean on hexahedra only."""
    kind, method = row.model[:2]
    return method is not None and not (kind == "tets" and method == "green")
