#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints where the source stands against its budgets: lengths of headers, .cpp files and functions, the share of
documentation in the framework's headers, tests against source. With --limits it exits with 1 when a header is over 300
lines, a .cpp over 400, a function over 60 without a reason (a comment with "long because" at its top), or the engine,
framework/, over 16,500 lines; the rest only guides.

Usage: check_budgets.py [--limits] [--worst N]"""
import argparse
import os
import re
import statistics
import sys

TREE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(TREE, "tests", "support"))
from tree_files import tree_files  # noqa: E402 pylint: disable=wrong-import-position

ENGINE_LINES = 16500
OPENING = re.compile(r"^\s*(?:if|for|while|switch|else|do|catch|try|namespace|struct|class|enum|union|extern)\b|^\s*[{}]|\[[^\]]*\]\s*(?:\(|\{)|=\s*\{")


def sources(*folders, ends=(".h", ".cpp")):
    for path in tree_files(TREE):
        if path.split("/")[0] in folders and path.endswith(ends):
            yield os.path.join(TREE, path)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read().split("\n")[:-1]


def without_text(line):
    """The line without strings, characters and a trailing comment, so that braces can be counted."""
    line = re.sub(r'"(\\.|[^"\\])*"', '""', line)
    line = re.sub(r"'(\\.|[^'\\])'", "''", line)
    return line.split("//")[0]


def functions(path):
    """(first line, number of lines, name, reason given) of every function body of more than one line. Finds a
    signature by its shape, which is enough for code in the repository's own format."""
    lines = read(path)
    plain = [without_text(line) for line in lines]
    raw_string = False
    index = 0
    while index < len(lines):
        if 'R"' in lines[index] and ')"' not in lines[index].split('R"', 1)[1]:
            raw_string = True
        if raw_string:
            raw_string = not re.search(r'\)\w*"', lines[index]) or 'R"' in lines[index]
            index += 1
            continue
        line = plain[index]
        if not (line.rstrip().endswith("{") and ")" in "".join(plain[max(0, index - 3):index + 1])):
            index += 1
            continue
        start = index  # a signature may begin some lines earlier
        while start > 0 and "(" not in plain[start] or plain[start].count(")") > plain[start].count("("):
            if start == 0 or plain[start - 1].rstrip().endswith((";", "{", "}")) or not plain[start - 1].strip():
                break
            start -= 1
        signature = " ".join(plain[start:index + 1])
        if "(" not in signature or OPENING.search(plain[start]):
            index += 1
            continue
        depth, end = 0, index
        while end < len(lines):
            depth += plain[end].count("{") - plain[end].count("}")
            if depth <= 0:
                break
            end += 1
        names = re.findall(r"([\w~:]+|operator\S+)\s*\(", signature)
        reason = any("long because" in text for text in lines[max(0, start - 4):start + 4])
        yield start + 1, end - start + 1, names[0] if names else "?", reason
        index = end + 1


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limits", action="store_true", help="exit with 1 where a hard limit is passed")
    parser.add_argument("--worst", type=int, default=5, help="how many of the longest to list")
    arguments = parser.parse_args()

    headers = {path: read(path) for path in sources("framework", "components", "tools", ends=(".h",))}
    bodies = {path: read(path) for path in sources("framework", "components", "tools", ends=(".cpp",))}
    tests = sum(len(read(path)) for path in sources("tests"))
    total = sum(len(lines) for lines in [*headers.values(), *bodies.values()])
    found = [(length, os.path.relpath(path, TREE), line, name, reason) for path in [*headers, *bodies]
             for line, length, name, reason in functions(path)]
    if not headers or not bodies or not found:
        sys.exit("no source found: is this the whole tree?")
    framework_headers = [lines for path, lines in headers.items() if os.sep + "framework" + os.sep in path]
    documented = sum(1 for lines in framework_headers for line in lines if "//" in line)
    documentable = sum(1 for lines in framework_headers for line in lines if line.strip())

    def show(name, value, budget, good):
        print(f"{name:42} {value:>8}   budget {budget:10} {'' if good else '<-- over'}")

    median_header = statistics.median(len(lines) for lines in headers.values())
    median_body = statistics.median(len(lines) for lines in bodies.values())
    too_long = {path: len(lines) for files, limit in ((headers, 300), (bodies, 400)) for path, lines in files.items()
                if len(lines) > limit}
    longest_header, longest_body = (max(len(lines) for lines in files.values()) for files in (headers, bodies))
    lengths = [entry[0] for entry in found]
    unexplained = [entry for entry in found if entry[0] > 60 and not entry[4]]
    show("header, median lines", f"{median_header:g}", "90", median_header <= 90)
    show("header, longest", longest_header, "300", longest_header <= 300)
    show(".cpp, median lines", f"{median_body:g}", "250", median_body <= 250)
    show(".cpp, longest", longest_body, "400", longest_body <= 400)
    show("function, 90th percentile", percentile(lengths, 0.9), "20", percentile(lengths, 0.9) <= 20)
    show("function, longest", max(lengths), "60", max(lengths) <= 60)
    show("functions over 60 lines without a reason", len(unexplained), "0", not unexplained)
    engine = sum(len(lines) for path, lines in [*headers.items(), *bodies.items()] if os.sep + "framework" + os.sep in path)
    show("framework/, lines", engine, f"{ENGINE_LINES}", engine <= ENGINE_LINES)
    share = documented / documentable
    show("framework headers, share with comments", f"{share:.2f}", "0.33", share >= 0.33)
    show("test lines over source lines", f"{tests / total:.2f}", "0.5 or more", tests / total >= 0.5)
    print(f"\n{len(headers)} headers, {len(bodies)} .cpp files, {len(found)} functions of several lines, "
          f"{total} lines of source, {tests} of tests")
    print("longest functions:")
    for length, path, line, name, reason in sorted(found, reverse=True)[:arguments.worst]:
        print(f"  {length:4} lines  {path}:{line}  {name}{'  (reason given)' if reason else ''}")
    print("longest files:")
    for path, lines in sorted({**headers, **bodies}.items(), key=lambda item: -len(item[1]))[:arguments.worst]:
        print(f"  {len(lines):4} lines  {os.path.relpath(path, TREE)}")
    if arguments.limits and (too_long or unexplained or engine > ENGINE_LINES):
        if engine > ENGINE_LINES:
            print(f"over the limit: framework/ has {engine} lines: what one tool alone needs, or one family, lives there")
        for path, length in too_long.items():
            print(f"over the limit: {os.path.relpath(path, TREE)} has {length} lines")
        for length, path, line, name, _ in unexplained:
            print(f"over the limit: {path}:{line} {name} has {length} lines")
        sys.exit(1)


if __name__ == "__main__":
    main()
