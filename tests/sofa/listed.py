# SPDX-License-Identifier: LGPL-2.1-or-later
"""SOFA's lists of contacts, in its order, by hand: trees of boxes, pairs of models, filters, and its sweeps with friction."""
import numpy as np

PLACE = {"triangle": 0, "line": 1, "sphere": 2, "point": 3}


class Model:
    """Parts (tuples of nodes) of a body whose rows begin at `base`; a body that is not simulated has a base below 0 and places of its own."""

    def __init__(self, kind, parts, body, base, node, simulated=True, radius=0.0, places=None, skin=0.0):
        self.kind, self.parts, self.body, self.base, self.node = kind, [tuple(p) for p in parts], body, base, node
        self.simulated, self.radius, self.places, self.skin, self.order = simulated, radius, places, skin, None

    def at(self, part, x):
        return np.array([self.places[i] if self.base < 0 else x[self.base + i] for i in self.parts[part]])

    def boxes(self, x):
        grown = self.radius + self.skin
        return [(p.min(0) - grown, p.max(0) + grown) for p in (self.at(i, x) for i in range(len(self.parts)))]


def whole(boxes):
    return np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)


def tree(items, boxes, depth):
    """A cell as a list of cells, a leaf as a number. Cells of four leaves or fewer are not cut."""
    if depth == 0 or len(items) <= 4:
        return list(items)
    low, high = whole([boxes[i] for i in items])
    x, y, z = high - low
    axis = (0 if x > z else 2) if x > y else (1 if y > z else 2)
    items = sorted(items, key=lambda i: boxes[i][0][axis] + boxes[i][1][axis])
    half = (len(items) + 1) // 2
    return [("cell", tree(items[:half], boxes, depth - 1)), ("cell", tree(items[half:], boxes, depth - 1))]


def leaves(cell):
    return [i for child in cell for i in (leaves(child[1]) if isinstance(child, tuple) else [child])]


def pairs(cells_a, cells_b, boxes_a, boxes_b, margin):
    """Leaves that meet at once; of the others the last pair of cells first, each to its end."""
    later = []
    for a in cells_a:
        for b in cells_b:
            box_a = whole([boxes_a[i] for i in leaves([a])])
            box_b = whole([boxes_b[i] for i in leaves([b])])
            if np.any(box_a[0] - margin > box_b[1]) or np.any(box_b[0] - margin > box_a[1]):
                continue
            if not isinstance(a, tuple) and not isinstance(b, tuple):
                yield a, b
            else:
                later.append((a[1] if isinstance(a, tuple) else [a], b[1] if isinstance(b, tuple) else [b]))
    for a, b in reversed(later):
        yield from pairs(a, b, boxes_a, boxes_b, margin)


def in_plane(x, q):
    e, f, d = x[1] - x[0], x[2] - x[0], q - x[0]
    b, c = np.linalg.solve([[e @ e, e @ f], [e @ f, f @ f]], [d @ e, d @ f])
    return np.array([1 - b - c, b, c])


def nearest(method, a, b, x, y):
    """Weights of the two points, or nothing."""
    kinds = a.kind, b.kind
    if a.kind == "triangle":
        w = in_plane(x, y[0])
        return (w, np.ones(1)) if min(w[1:]) >= 1e-6 and w[0] >= 1e-6 else None
    if kinds == ("line", "line"):
        e, f, d = x[1] - x[0], y[1] - y[0], y[0] - x[0]
        s, t = np.linalg.solve([[e @ e, -e @ f], [-e @ f, f @ f]], [e @ d, -f @ d])
        rim = 1e-15 if method == "LocalMinDistance" else 1e-6
        return (np.array([1 - s, s]), np.array([1 - t, t])) if rim <= min(s, t) and max(s, t) <= 1 - rim else None
    if a.kind == "line":
        e = x[1] - x[0]
        s = (y[0] - x[0]) @ e / (e @ e)
        if b.kind == "sphere" and method == "MinProximityIntersection":
            s = 1 - s
        if method == "LocalMinDistance" or b.kind == "sphere":
            if s < 1e-6 or s > 1 - 1e-6:
                return None
        s = min(max(s, 0.0), 1.0)
        return np.array([1 - s, s]), np.ones(1)
    return np.ones(1), np.ones(1)


class Numbers:
    def __init__(self):
        self.of = {}

    def compare(self, left, right):
        for model in (left[1], left[0], right[1], right[0]):
            self.of.setdefault(model, len(self.of))

    def key(self, pair):
        return tuple(self.of.get(model, 0) for model in pair)


class Lists:
    def __init__(self, models, method, alarm, contact, depth=6):
        self.models, self.method, self.alarm, self.contact, self.depth = models, method, alarm, contact, depth
        self.found, self.answered, self.begun, self.searches = [], [], {}, 0
        self.found_numbers, self.answered_numbers = Numbers(), Numbers()

    def meet(self, a, b):
        kinds = {a.kind, b.kind}
        return (a.simulated or b.simulated) and a.body != b.body and not ("triangle" in kinds and kinds <= {"triangle", "line"})

    def contacts(self, x, rubs=True):
        """(first, second, {row: weight}, fixed part of Q - P, normal, distance) of each, in order."""
        boxes = [m.boxes(x) for m in self.models]
        for model, own in zip(self.models, boxes):
            if model.order is None:
                model.order = tree(range(len(own)), own, self.depth)
        outputs = {}
        for later in range(len(self.models)):
            for before in range(later):
                a, b = later, before
                if not self.meet(self.models[a], self.models[b]):
                    continue
                if PLACE[self.models[b].kind] < PLACE[self.models[a].kind]:
                    a, b = b, a
                low, high = whole(boxes[a]), whole(boxes[b])
                if np.any(low[0] - self.alarm > high[1]) or np.any(high[0] - self.alarm > low[1]):
                    continue
                if (a, b) not in self.found:
                    if self.found:
                        self.found_numbers.compare(self.found[-1], (a, b))
                    self.found = sorted(self.found + [(a, b)], key=self.found_numbers.key)
                outputs[a, b] = self.of_pair(self.models[a], self.models[b], boxes[a], boxes[b], x)
        self.found = [pair for pair in self.found if outputs.get(pair)]
        for pair in self.found:
            if pair not in self.answered:
                if self.answered:
                    self.answered_numbers.compare(pair, self.answered[0])
                self.answered = sorted(self.answered + [pair], key=self.answered_numbers.key)
        self.answered = [pair for pair in self.answered if pair in self.found]
        if len(self.found) == 1:
            self.found_numbers.compare(self.found[0], self.found[0])
        order = sorted(self.answered, key=lambda pair: self.node_of(*pair))
        self.begun = {pair: self.begun.get(pair, self.searches) for pair in self.answered}
        for pair in order:
            for c in outputs[pair]:  # the complement in the first step, by which no later one knows it
                c["name"] = pair, self.begun[pair], c["number"] if self.begun[pair] < self.searches else ~c["number"]
        self.searches += 1
        return [c for pair in order for c in (self.without_doubles if rubs else self.nearest_of_each)(outputs[pair])]

    def node_of(self, a, b):
        for one, other in ((a, b), (b, a)):
            if not self.models[one].simulated:
                return self.models[other].node
        return -1

    def of_pair(self, a, b, boxes_a, boxes_b, x):
        found = []
        skins = a.skin + b.skin + a.radius + b.radius
        for i, j in pairs(a.order, b.order, boxes_a, boxes_b, self.alarm):
            p, q = a.at(i, x), b.at(j, x)
            weights = nearest(self.method, a, b, p, q)
            if weights is None:
                continue
            way = weights[1] @ q - weights[0] @ p
            distance = np.linalg.norm(way)
            if distance >= self.alarm + skins:
                continue
            rows, fixed = {}, np.zeros(3)
            for model, part, w, places, sign in ((a, i, weights[0], p, -1), (b, j, weights[1], q, 1)):
                for node, share, place in zip(model.parts[part], w, places):
                    if model.base < 0:
                        fixed = fixed + sign * share * place
                    else:
                        rows[model.base + node] = sign * share
            larger = i if len(a.parts) > len(b.parts) else j
            number = j if a.kind in ("triangle", "line") and b.kind in ("point", "sphere") else larger
            if a.kind == "sphere" and b.kind == "point" and self.method == "MinProximityIntersection":
                number = i
            found.append({"rows": rows, "fixed": fixed, "n": way / distance, "d": self.contact + skins, "number": number,
                          "value": distance - self.contact - skins, "points": (weights[0] @ p, weights[1] @ q)})
        return found

    @staticmethod
    def without_doubles(found):
        kept = []
        for each in found:
            if all(sum(np.sum((u - v) ** 2) for u, v in zip(each["points"], other["points"])) >= 1e-8 for other in kept):
                kept.append(each)
        return kept

    @staticmethod
    def nearest_of_each(found):
        return [c for c in found if c is min((o for o in found if o["number"] == c["number"]), key=lambda o: o["value"])]


def friction_rows(contacts, x, start):
    """Gradients and values at x of a push and two slides for each contact."""
    J, g = [], []
    for c in contacts:
        n = c["n"]
        s = np.cross(n, [n[2], n[0], n[1]])
        s /= np.linalg.norm(s)
        way = [c["fixed"] + sum(w * where[row] for row, w in c["rows"].items()) for where in (start, x)]
        before, after = (u @ n - c["d"] for u in way)
        moved = [sum(abs(sign) * w * (x[row] - start[row]) for row, w in c["rows"].items() if (w < 0) == (sign < 0)) + np.zeros(3)
                 for sign in (-1, 1)]
        little = 1e-5 * sum(np.linalg.norm(m) for m in moved)
        if abs(before) < little and abs(after) < little or abs(before - after) <= 1e-3 * before:
            share = 1.0
        else:
            met = before / (before - after)
            share = 1 - met if 0 < met < 1 else 1.0 if after < 0 else 0.0
        for direction, value in ((n, after), (-np.cross(n, s), None), (s, None)):
            row = np.zeros(x.size)
            for node, w in c["rows"].items():
                row[3 * node:3 * node + 3] += w * direction
            J.append(row)
            g.append(share * (way[1] - way[0]) @ direction if value is None else value)
    return np.array(J).reshape(-1, x.size), np.array(g)


def rubbed(W, g, mu, most, tolerance, start=None):
    """Sweeps over contacts with friction; with a start those of LCPConstraintSolver."""
    f = np.zeros(len(g)) if start is None else start.copy()
    limit = tolerance * (len(g) if start is None else len(g) / 3 + 1)
    for _ in range(most):
        error = 0
        for k in range(0, len(g), 3):
            old, d, w = f[k:k + 3].copy(), g[k:k + 3] + W[k:k + 3] @ f, W[k:k + 3, k:k + 3]
            f[k] -= d[0] / w[0, 0]
            if f[k] < 0:
                f[k:k + 3] = 0
            else:
                d = d + w[:, 0] * (f[k] - old[0])
                f[k + 1:k + 3] -= 2 * d[1:] / (w[1, 1] + w[2, 2])
                size = np.linalg.norm(f[k + 1:k + 3])
                if size > mu * f[k]:
                    f[k + 1:k + 3] *= mu * f[k] / size
            moved = f[k:k + 3] - old
            error += sum(np.linalg.norm(row * moved) for row in w) if start is None else np.linalg.norm(w @ moved)
        if error < limit:
            break
    return f
