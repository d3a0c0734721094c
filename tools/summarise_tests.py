#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads JUnit files of ctest and prints the tests that were skipped, then what those said that failed; before
the last line, which is "N passed, N failed", stands how many were skipped. A test of ctest that is a suite of GoogleTest counts as
the tests that it holds; the one in which it crashed is among those that failed. Of a test of ctest that holds many of Python's, those
that were skipped inside are told as well. Usage: summarise_tests.py FILE.xml... CTEST_EXIT_CODE.
Exit code 0 when nothing failed and ctest itself said so."""
import re
import sys
import xml.etree.ElementTree as ElementTree

MOST_LINES = 100  # of what one test said: its end


def cases_of(path):
    """The test cases of a file. Output of a crashed test may hold bytes that XML forbids."""
    with open(path, "rb") as file:
        text = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", "?", file.read().decode("utf-8", "replace"))
    return ElementTree.fromstring(text).iter("testcase")


def skipped_inside(case):
    """How many tests of pytest or unittest a test of ctest says that it has skipped."""
    said = case.findtext("system-out") or ""
    return sum(int(count) for pair in re.findall(r"\b\d+ passed, (\d+) skipped\b|^OK \(skipped=(\d+)", said, re.M) for count in pair if count)


class Suite:
    """What a test of ctest that is a suite of GoogleTest said: how many tests it has (0: it is none), how many of them passed, the
    output of each that failed, or in which it ended, by name, and whether it came to its end."""

    def __init__(self, case):
        said = case.findtext("system-out") or ""
        count = re.search(r"^\[=+\] Running (\d+) tests? from 1 test suite", said, re.M)
        self.count = int(count.group(1)) if count else 0
        tests = [re.split(r"\s", part, maxsplit=1) for part in re.split(r"\[ RUN      \] ", said)[1:]] if count else []
        is_cut = "[This part of the test output was removed" in said  # what ctest keeps of each test has a limit
        self.is_whole = is_cut or "[  PASSED  ] " in said

        def ended(name, text, word):
            return re.search(r"\[ +" + word + r" +\] " + re.escape(name) + r"(,| \()", text)

        self.failed = {name: text for name, text in tests
                       if (ended(name, text, "FAILED") if is_cut else not ended(name, text, "(OK|SKIPPED)"))}
        self.passed = sum(bool(ended(name, text, "OK")) for name, text in tests)
        if is_cut and case.find("failure") is None:
            self.passed = self.count - said.count("[  SKIPPED ] ")
        if self.failed and len(tests) < self.count and not is_cut:
            self.failed[tests[-1][0]] += f"\n{self.count - len(tests)} tests of the suite did not begin"


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    passed, failed, skipped, inside, said = 0, [], [], 0, {}

    def fails(name, text):
        failed.append(name)
        said[name] = text.strip().split("\n")[-MOST_LINES:]

    for case in (case for path in sys.argv[1:-1] for case in cases_of(path)):
        reason, name, suite = case.find("skipped"), case.get("name"), Suite(case)
        has_ended = not suite.count or (suite.is_whole and not suite.failed)  # not by exit(0) in one of its tests
        if case.get("status") == "run" and case.find("failure") is None and has_ended:
            if count := suite.count - suite.passed or skipped_inside(case):
                print(f"skipped: {count} inside {name}")
                inside += count
            passed += suite.passed if suite.count else 1
        elif case.get("status") == "disabled" or (reason is not None and "SKIP" in reason.get("message", "")):
            skipped.append(name)
        else:  # failed, timed out, crashed, or its program was not built
            passed += suite.passed
            for test, text in (suite.failed or {name: case.findtext("system-out") or ""}).items():
                fails(test, text)
    for name in skipped:
        print(f"skipped: {name}")
    for name in failed:
        print(f"\nfailed: {name}", *said[name], sep="\n")
    if failed:
        print("\nfailed:", *failed)
    elif int(sys.argv[-1]) != 0:
        print(f"ctest ended with {sys.argv[-1]} although no test is marked as failed")
        failed.append("ctest")
    if skipped or inside:
        print(f"{len(skipped) + inside} skipped")
    print(f"{passed} passed, {len(failed)} failed")
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()
