#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads JUnit files of ctest and prints the tests that were skipped, then what those said that failed; before
the last line, which is "N passed, N failed", stands how many were skipped. Of a test of ctest that holds many of Python's, those that were
skipped inside are told as well. Usage: summarise_tests.py FILE.xml... CTEST_EXIT_CODE.
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


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    passed, failed, skipped, inside, said = [], [], [], 0, {}
    for case in (case for path in sys.argv[1:-1] for case in cases_of(path)):
        reason = case.find("skipped")
        if case.get("status") == "run" and case.find("failure") is None:
            passed.append(case.get("name"))
            if count := skipped_inside(case):
                print(f"skipped: {count} inside {case.get('name')}")
                inside += count
        elif case.get("status") == "disabled" or (reason is not None and "SKIP" in reason.get("message", "")):
            skipped.append(case.get("name"))
        else:  # failed, timed out, crashed, or its program was not built
            failed.append(case.get("name"))
            said[case.get("name")] = (case.findtext("system-out") or "").strip().split("\n")[-MOST_LINES:]
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
    print(f"{len(passed)} passed, {len(failed)} failed")
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()
