#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Closed surfaces of a bowl and of a ball, for `stroma mesh`:

    scenes/meshes/make_bowl.py --bowl bowl.obj --ball ball.obj
    stroma mesh bowl.obj -o bowl.msh --msh22 --cell-size 0.022 --facet-size 0.018 --distance 0.0015 --name 1=bowl
    stroma mesh ball.obj -o ball.msh --msh22 --cell-size 0.012 --facet-size 0.009 --distance 0.001 --name 1=ball

The bowl is a spherical shell of inner radius 70 mm and 12 mm thick on a flat foot; the lowest point inside is the origin, y is up. The
ball has a radius of 18 mm and its centre at the origin.
"""
import argparse
import math


def revolved(profile, around):
    """Triangles of the surface that a line from axis to axis, a list of (radius, height), sweeps around y."""
    points, rings = [], []
    for radius, height in profile:
        count = 1 if radius == 0 else around
        rings.append([len(points) + k for k in range(count)])
        points += [(radius * math.cos(2 * math.pi * k / count), height, radius * math.sin(2 * math.pi * k / count)) for k in range(count)]
    triangles = []
    for lower, upper in zip(rings, rings[1:]):
        for k in range(around):
            a, b = lower[k % len(lower)], lower[(k + 1) % len(lower)]
            c, d = upper[k % len(upper)], upper[(k + 1) % len(upper)]
            triangles += [(a, c, b)] if len(lower) > 1 else []
            triangles += [(b, c, d)] if len(upper) > 1 else []
    return points, triangles


def arc(radius, centre, first, last, parts):
    """Points of a circle about (0, centre), angles in degrees from straight down."""
    angles = [math.radians(first + (last - first) * k / parts) for k in range(parts + 1)]
    return [(radius * math.sin(a), centre - radius * math.cos(a)) for a in angles]


def write(path, surface):
    points, triangles = surface
    with open(path, "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % p for p in points)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)


def bowl(inner=0.07, thickness=0.012, rim=75, foot=25):
    outer = inner + thickness
    base = outer * math.cos(math.radians(foot)) - inner  # below the origin
    outside = [(0, -base), (outer * math.sin(math.radians(foot)) / 2, -base)] + arc(outer, inner, foot, rim, 12)
    inside = arc(inner, inner, rim, 0, 16)
    inside[-1] = (0, 0)
    return revolved(outside + inside, 48)


def ball(radius=0.018):
    line = arc(radius, 0, 0, 180, 16)
    line[0], line[-1] = (0, -radius), (0, radius)
    return revolved(line, 32)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bowl", default="bowl.obj", help="file of the bowl (default %(default)s)")
    parser.add_argument("--ball", default="ball.obj", help="file of the ball (default %(default)s)")
    options = parser.parse_args()
    write(options.bowl, bowl())
    write(options.ball, ball())
