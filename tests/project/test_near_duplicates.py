#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/near_duplicates.py must find a planted copy with other names, and nothing in what only looks alike by chance."""
import os
import subprocess
import sys
import tempfile

FUNCTION = """double sumOf(const std::vector<double>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i] * factorOf(i);
    // a comment does not count
    sum += value > 0 ? value : -value;
    if (sum > 1e3) return report("too much", sum);
    counts[i] = std::max(counts[i], int(value));
  }
  return sum / double(values.size());
}
"""
COPY = (FUNCTION.replace("sum", "total").replace("values", "masses").replace("1e3", "200").replace("too much", "heavy")
        .replace("  // a comment does not count\n", "\n"))
OTHER = "\n".join(f"  const double part{i} = {'first(' * (i % 3)}value{i}{')' * (i % 3)} {'+-*/'[i % 4]} {i};" for i in range(12))


def said_of(tool, files, *options):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            os.makedirs(os.path.join(folder, os.path.dirname(name)), exist_ok=True)
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        subprocess.run(["git", "init", "-q", folder], check=True)
        subprocess.run(["git", "-C", folder, "add", "."], check=True)
        return subprocess.run([sys.executable, tool, folder, *options], capture_output=True, text=True, check=True).stdout


def main():
    tool = os.path.join(sys.argv[1], "tools", "near_duplicates.py")
    files = {"framework/a.cpp": "int before = 1;\n" + FUNCTION, "tools/b/c.cpp": COPY + OTHER, "tools/b/d.txt": FUNCTION}
    out = said_of(tool, files, "--lines", "8")
    assert out.splitlines()[0].split() == ["8", "lines", "framework/a.cpp:2", "tools/b/c.cpp:1"], out
    assert ["framework", "1", "pairs"] in [line.split() for line in out.splitlines()], out
    assert "lines" not in said_of(tool, files, "--lines", "9"), "one line more than the copy has"
    print("copies are found")


if __name__ == "__main__":
    main()
