#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/summarise_tests.py must count what ctest's JUnit file says, and must not be good by mistake."""
import os
import subprocess
import sys
import tempfile

PASS = '<testcase name="a" status="run"/>'
FAIL = '<testcase name="b" status="fail"><failure message=""/><system-out>bad \x01</system-out></testcase>'
SKIP = '<testcase name="c" status="notrun"><skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/></testcase>'
CODE = '<testcase name="d" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/></testcase>'
GONE = '<testcase name="e" status="notrun"><skipped message="Unable to find executable"/></testcase>'
OFF = '<testcase name="f" status="disabled"/>'
INSIDE = '<testcase name="g" status="run"><system-out>...s. [100%]\n4 passed, 1 skipped in 2.1s</system-out></testcase>'
UNITTEST = '<testcase name="h" status="run"><system-out>Ran 9 tests in 1s\nOK (skipped=2)</system-out></testcase>'
# suites of GoogleTest
BEGIN = '"><system-out>[==========] Running 3 tests from 1 test suite.\nx[ RUN      ] S.{}\nfirst\n'.format
GOOD = '<testcase name="t.S" status="run' + BEGIN("a") + '[       OK ] S.a (0 ms)\n[ RUN      ] S.b\nwhy\n[  SKIPPED ] S.b (0 ms)\n' \
    '[ RUN      ] S.c\nx[       OK ] S.c (1 ms)\n[  PASSED  ] 2 tests.</system-out></testcase>'
BAD = '<testcase name="t.S" status="fail' + BEGIN("a/0") + '[  FAILED  ] S.a/0, where GetParam() = "x y" (0 ms)\n[ RUN      ] S.b\n' \
    '[       OK ] S.b (0 ms)\n[ RUN      ] S.c\n[       OK ] S.c (1 ms)\n[  FAILED  ] 1 test, listed below:</system-out><failure message=""/></testcase>'
CRASH = '<testcase name="t.S" status="fail' + BEGIN("a") + '[       OK ] S.a (0 ms)\n[ RUN      ] S.b\nbegins</system-out><failure message=""/></testcase>'
LEFT = CRASH.replace("fail", "run", 1).replace('<failure message=""/>', "")  # by exit(0)
LEFT_AT_END = GOOD.replace("[       OK ] S.c (1 ms)\n[  PASSED  ] 2 tests.", "")
LAST = GOOD.replace('"run"', '"fail"').replace("[       OK ] S.c (1 ms)\n[  PASSED  ] 2 tests.",
                                             "bad\n[  FAILED  ] S.c (1 ms)\n[  PASSED  ] 1 test.\n[  SKIPPED ] 1 test, listed below:\n[  SKIPPED ] S.b\n")
LAST = LAST.replace("</testcase>", '<failure message=""/></testcase>')
AT_EXIT = CRASH.replace("[ RUN      ] S.b\n", "")
NONE_HERE = '<testcase name="t.S" status="run"><system-out>[==========] Running 3 tests from 1 test suite.\nno AVX\n[  PASSED  ] 0 tests.' \
    '</system-out></testcase>'
CUT = GOOD.replace("[ RUN      ] S.c\nx[       OK ] S.c (1 ms)\n[  PASSED  ] 2 tests.", "[This part of the test output was removed since ...]")
CUT_BAD = LAST.replace("[ RUN      ] S.c\n", "[This part of the test output was removed since ...]")
CASES = [  # cases, exit code of ctest, the end of what is said, exit code
    ([PASS, PASS], 0, "2 passed, 0 failed", 0),
    ([PASS, FAIL], 8, "1 passed, 1 failed", 1),
    ([PASS, SKIP, CODE, OFF], 0, "3 skipped\n1 passed, 0 failed", 0),
    ([PASS, INSIDE, UNITTEST, SKIP], 0, "4 skipped\n3 passed, 0 failed", 0),
    ([PASS, GONE], 8, "1 passed, 1 failed", 1),
    ([PASS, GONE], 0, "1 passed, 1 failed", 1),
    ([PASS], 8, "1 passed, 1 failed", 1),  # ctest says that something went wrong
    ([SKIP], 0, "1 skipped\n0 passed, 0 failed", 1),
    ([], 0, "0 passed, 0 failed", 1),
    ([GOOD, PASS], 0, "1 skipped\n3 passed, 0 failed", 0),
    ([CUT], 0, "1 skipped\n2 passed, 0 failed", 0),
    ([GOOD, BAD], 8, "failed: S.a/0\n1 skipped\n4 passed, 1 failed", 1),
    ([BAD], 8, "failed: S.a/0\nfirst\n[  FAILED  ] S.a/0, where GetParam() = \"x y\" (0 ms)\n\nfailed: S.a/0\n2 passed, 1 failed", 1),
    ([CRASH], 8, "failed: S.b\nbegins\n1 tests of the suite did not begin\n\nfailed: S.b\n1 passed, 1 failed", 1),
    ([LEFT], 0, "failed: S.b\nbegins\n1 tests of the suite did not begin\n\nfailed: S.b\n1 passed, 1 failed", 1),
    ([LEFT_AT_END], 0, "failed: S.c\n1 passed, 1 failed", 1),
    ([LAST], 8, "failed: S.c\n1 passed, 1 failed", 1),
    ([CUT_BAD], 8, "failed: t.S\n1 passed, 1 failed", 1),
    ([AT_EXIT], 8, "failed: t.S\n1 passed, 1 failed", 1),
    ([NONE_HERE, PASS], 0, "3 skipped\n1 passed, 0 failed", 0),
]


def main():
    script = os.path.join(sys.argv[1], "tools", "summarise_tests.py")
    with tempfile.TemporaryDirectory() as folder:
        for cases, ctest_code, end, code in CASES:
            path = os.path.join(folder, "tests.xml")
            with open(path, "w", encoding="utf-8") as file:
                file.write('<?xml version="1.0" encoding="UTF-8"?><testsuite>' + "".join(cases) + "</testsuite>")
            result = subprocess.run([sys.executable, script, path, str(ctest_code)], capture_output=True, text=True)
            if FAIL in cases:
                assert "failed: b\nbad ?\n" in result.stdout, result.stdout
            lines = result.stdout.strip().split("\n")
            got = "\n".join(lines[-len(end.split("\n")):])
            assert (got, result.returncode) == (end, code), (cases, got, result.returncode, result.stderr)
            assert ("skipped" in "\n".join(lines[-2:])) == ("skipped" in end), lines
        both = [os.path.join(folder, name) for name in ("first.xml", "second.xml")]
        for path, cases in zip(both, ([PASS, SKIP], [FAIL, PASS])):
            with open(path, "w", encoding="utf-8") as file:
                file.write("<testsuite>" + "".join(cases) + "</testsuite>")
        result = subprocess.run([sys.executable, script, *both, "8"], capture_output=True, text=True)
        assert result.stdout.endswith("\nfailed: b\nbad ?\n\nfailed: b\n1 skipped\n2 passed, 1 failed\n"), result
    print(f"{len(CASES)} summaries as expected")


if __name__ == "__main__":
    main()
