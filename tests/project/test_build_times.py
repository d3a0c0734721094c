#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/build_times.py must add up a planted log, tell a unit over the limit, and refuse what is no log."""
import os
import subprocess
import sys
import tempfile

LOG = """# ninja log v5
0\t9000\t1\tframework/CMakeFiles/stroma.dir/a.cpp.o\t1
0\t2500\t2\tframework/CMakeFiles/stroma.dir/a.cpp.o\t1
100\t4100\t3\tcomponents/loads/CMakeFiles/loads.dir/b.cpp.o\t2
0\t1500\t3\tcomponents/loads/CMakeFiles/loads.dir/c.cpp.o\t2
0\t60000\t4\tbin/stroma\t3
"""


def said_of(tool, log, *options):
    with tempfile.TemporaryDirectory() as folder:
        if log is not None:
            with open(os.path.join(folder, ".ninja_log"), "w") as file:
                file.write(log)
        done = subprocess.run([sys.executable, tool, folder, *options], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def main():
    tool = os.path.join(sys.argv[1], "tools", "build_times.py")
    code, out, err = said_of(tool, LOG, "--slowest", "1")
    assert code == 0, err
    rows = [line.split() for line in out.splitlines()]
    assert ["components/loads", "2", "5.5"] in rows, out
    assert ["framework", "1", "2.5"] in rows, out  # the last time of a unit counts
    assert ["sum", "3", "8.0"] in rows, out  # what is linked is no unit
    assert ["4.0", "components/loads/CMakeFiles/loads.dir/b.cpp.o"] in rows, out
    assert any(row[0] == "framework" and len(row) == 2 and int(row[1]) > 1000 for row in rows if row), out
    assert said_of(tool, LOG, "--limit", "4")[0] == 0
    code, out, err = said_of(tool, LOG, "--limit", "3.9")
    assert code == 1 and "b.cpp.o took 4.0 s, longer than 3.9 s" in err, err
    for text in (None, "", "something else\n", LOG + "1\t2\n"):
        code, out, err = said_of(tool, text)
        assert code == 2 and out == "" and "build_times.py:" in err, (text, code, out, err)
    print("build times are added up")


if __name__ == "__main__":
    main()
