#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tests/mutants must find the places that can be made wrong, and only those. Usage: test_mutants.py TREE"""
import os
import sys

PLANTED = {  # a line of code: the changed lines that are expected, all of them
    "double f = a + b * c;": ["double f = a - b * c;", "double f = a;", "double f = a + b;"],
    "sum += x[i] - y;": ["sum -= x[i] - y;", ";", "sum += x[i] + y;", "sum += x[i];"],
    "x = 0.5 * pull(j, i);": ["x = 1.0 * pull(j, i);", "x = 0.5;", "x = 0.5 * pull(i, j);"],
    "y = scale(-force) / 3;": ["y = scale(force) / 3;", "y = scale(-force);", "y = scale(-force) / 6;"],
    "z = w[0];": ["z = w[1];"],
    "z = dot(a, b);": [],
    "if (a < b) go();": ["if (a <= b) go();", "if (!(a < b)) go();"],
    'if (a == b) throw Error("a + b");': ['if (a != b) throw Error("a + b");', 'if (!(a == b)) throw Error("a + b");'],
    "while (a && b) go();": ["while (a || b) go();"],
    "for (int i = 0; i < n; ++i) go();": ["for (int i = 0; i + 1 < n; ++i) go();"],
    "return true;": ["return false;"],
    "return value(x);": ["return {};"],
    "return nullptr;": [],
    "x = 1e-4 * step;": ["x = 1e-4;"],
    "// a + b": [],
    'say("a + b" + name, x + y);': [],
    "#define LARGE a + b": [],
    "std::array<double, 2 * 3> p;": [],
    "template <int n = a + b>": [],
    "static_assert(a == b);": [],
    'table.add("limit", limit_).min(2 * a);': [],
}


def main():
    sys.path.insert(0, os.path.join(sys.argv[1], "tests", "mutants"))
    import sites
    text = "".join(f"void f{n}() {{\n  {line}\n}}\n" if not line.startswith("#") else line + "\n"
                   for n, line in enumerate(PLANTED))
    found = {}
    for site in sites.sites_of("planted.cpp", text):
        before, after = site.before_and_after(text)
        found.setdefault(before, []).append(after)
        assert site.apply(text).count("\n") == text.count("\n"), "lines keep their numbers"
    for line, expected in PLANTED.items():
        assert sorted(found.get(line, [])) == sorted(expected), (line, found.get(line, []))
    order, texts = sites.choose(sys.argv[1], 1)
    assert order == sites.choose(sys.argv[1], 1)[0], "the seed alone chooses"
    assert len(order) > 3000 and {site.kind for site in order[:300]} == set(sites.KINDS), "all kinds"
    assert all(site.apply(texts[site.path]) != texts[site.path] for site in order)
    print(f"{len(PLANTED)} lines changed as expected; {len(order)} lines of the tree can be changed")


if __name__ == "__main__":
    main()
