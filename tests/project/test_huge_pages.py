#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A compiler with memory on huge pages writes the object that it writes without, with a precompiled header and where there are
fewer addresses than it would reserve. Whether the library was at work is read from the addresses that the compiler asks for huge
pages. What a build does is in cmake/huge_pages.cmake, which is used here as it is.
Usage: test_huge_pages.py SOURCE_FOLDER"""
import os
import resource
import subprocess
import sys
import tempfile

PROJECT = """cmake_minimum_required(VERSION 3.25)
project(pages CXX)
set(CMAKE_CXX_STANDARD 20)
include({source}/cmake/huge_pages.cmake)
stroma_try_huge_pages(launcher)
file(WRITE ${{CMAKE_BINARY_DIR}}/launcher "${{launcher}}")
"""
SWITCH = "/sys/kernel/mm/transparent_hugepage/enabled"
HEADER = "#include <map>\n#include <regex>\n#include <string>\n#include <vector>\n"
UNIT = """int main(int count, char** words) {
  std::map<std::string, std::vector<int>> lengths;
  for (int i = 0; i < count; ++i) lengths[words[i]].push_back(i);
  return static_cast<int>(lengths.size());
}
"""
# Prints from within the process, where a compiler would be, how many kilobytes ask for huge pages.
PROBE = "awk '/^Size/ {size = $2} /^VmFlags/ && / hg/ {sum += size} END {print sum + 0}' /proc/self/smaps"


def run(command, folder, addresses=None):
    limit = (lambda: resource.setrlimit(resource.RLIMIT_AS, (addresses, addresses))) if addresses else None
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, preexec_fn=limit)
    assert result.returncode == 0 and not result.stderr, f"{command}:\n{result.stdout}{result.stderr}"
    return result.stdout


def compiled(folder, launcher, addresses=None):
    """The bytes of the unit's object."""
    run([*launcher, "c++", "-std=c++20", "-O1", "-x", "c++-header", "-c", "all.h", "-o", "all.h.gch"], folder, addresses)
    run([*launcher, "c++", "-std=c++20", "-O1", "-Winvalid-pch", "-include", "all.h", "-c", "unit.cpp", "-o", "unit.o"], folder, addresses)
    with open(os.path.join(folder, "unit.o"), "rb") as file:
        return file.read()


def main():
    source = os.path.abspath(sys.argv[1])
    if not os.path.exists(SWITCH) or "[never]" in open(SWITCH, encoding="ascii").read():
        print("skipped: this kernel gives no huge pages, and compilers are started as they are")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        for name, text in [("CMakeLists.txt", PROJECT.format(source=source)), ("all.h", HEADER), ("unit.cpp", UNIT)]:
            with open(os.path.join(folder, name), "w", encoding="ascii") as file:
                file.write(text)
        run(["cmake", "-S", ".", "-B", "build", "-G", "Ninja"], folder)
        with open(os.path.join(folder, "build", "launcher"), encoding="utf-8") as file:
            launcher = [word for word in file.read().split(";") if word]
        assert launcher, "the kernel gives huge pages, and no compiler ran with the library"
        asked = int(run([*launcher, "sh", "-c", PROBE], folder))
        assert asked >= 8 << 20, f"{asked} kB of the compiler's addresses ask for huge pages"
        plain = compiled(folder, [])
        assert compiled(folder, launcher) == plain, "another object on huge pages"
        assert compiled(folder, launcher, addresses=4 << 30) == plain, "another object with few addresses"
    return 0


if __name__ == "__main__":
    sys.exit(main())
