#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A comment that changes in a precompiled header makes ccache compile the header again. A cached one from before the change
would hold the old content, and the compiler would read the new file a second time: what it defines would be defined twice.
A text that the assembler takes into a program is that of the file, whatever the cache has. Where clang is there, so with clang too,
which compiles the tests and tells changed files by their size: a comment changes without another size besides.
Usage: test_compiler_cache.py SOURCE_FOLDER"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PROJECT = """cmake_minimum_required(VERSION 3.25)
project(cached CXX)
set(CMAKE_CXX_STANDARD 20)
{launcher}
add_executable(cached use.cpp)
target_precompile_headers(cached PRIVATE precompiled.h)
target_include_directories(cached PRIVATE {source})
target_compile_options(cached PRIVATE -fpch-preprocess)
"""
USE = """#include <iostream>
#include "kind.h"
#include "tools/platform/text_file.h"
STROMA_TEXT_FILE(text, %s)
int main() { std::cout << text() << static_cast<int>(Kind::other); }
"""
HEADER = "// {comment}\n#pragma once\nenum class Kind {{ one, other }};\n"


def write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        file.write(text)


def build(folder, comment, text, anew=True):
    """Builds the small project, in a new build folder or the present one, and returns how often the cache was hit."""
    write(folder, "kind.h", HEADER.format(comment=comment))
    write(folder, "text.txt", text)
    if anew:
        shutil.rmtree(os.path.join(folder, "build"), ignore_errors=True)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("CCACHE_")}
    environment |= {"CCACHE_DIR": os.path.join(folder, "cache"), "CCACHE_CONFIGPATH": os.devnull}
    for command in [["ccache", "-z"], ["cmake", "-S", ".", "-B", "build", "-G", "Ninja"], ["cmake", "--build", "build"]]:
        result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert result.returncode == 0, f"{' '.join(command)}:\n{result.stdout}{result.stderr}"
    said = subprocess.run([os.path.join(folder, "build", "cached")], capture_output=True, text=True, check=True).stdout
    assert said == text + "1", f"the program has {said}, and the file {text}"
    counts = subprocess.run(["ccache", "--print-stats"], env=environment, capture_output=True, text=True, check=True).stdout
    return sum(int(line.split()[1]) for line in counts.splitlines() if line.split()[0] in ("direct_cache_hit", "preprocessed_cache_hit"))


def changes_come_through(source, launcher):
    with tempfile.TemporaryDirectory() as folder:
        write(folder, "CMakeLists.txt", PROJECT.format(launcher=launcher, source=source))
        write(folder, "use.cpp", USE % f'"{folder}/text.txt"')
        write(folder, "precompiled.h", '#include "kind.h"\n')
        assert build(folder, "One of two.", "before") == 0
        assert build(folder, "One of two kinds.", "before") == 0
        assert build(folder, "One of two.", "after") >= 1, "the cache does not know again what it has compiled"
        build(folder, "One of ten.", "after", anew=False)
        build(folder, "One of two kinds.", "after", anew=False)


def main():
    if not shutil.which("ccache"):
        print("skipped: ccache is not installed, and is not used then")
        return 77
    with open(os.path.join(sys.argv[1], "CMakeLists.txt"), encoding="utf-8") as file:
        launcher = re.search(r"find_program\(CCACHE.*?\nendif\(\)\n", file.read(), re.DOTALL).group(0)
    launcher = launcher.replace("${CMAKE_SOURCE_DIR}", sys.argv[1])
    changes_come_through(sys.argv[1], launcher)
    if clang := shutil.which("clang++"):
        by_clang = f"sh {sys.argv[1]}/cmake/with_clang.sh ${{CMAKE_CXX_COMPILER}} {clang} ${{CMAKE_CXX_COMPILER_LAUNCHER}}"
        changes_come_through(sys.argv[1], f"{launcher}set(CMAKE_CXX_COMPILER_LAUNCHER {by_clang})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
