# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the checks of the tree share: its files, their command line, and a self-test that plants files and expects each finding."""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tree_files import tree_files  # noqa: E402 pylint: disable=wrong-import-position


def self_test(planted, problems):
    """`planted`: path -> (text, a part of the one finding expected there, or None). `problems(tree)`: findings, files read."""
    with tempfile.TemporaryDirectory() as tree:
        for path, (text, _) in planted.items():
            os.makedirs(os.path.dirname(os.path.join(tree, path)), exist_ok=True)
            with open(os.path.join(tree, path), "w", encoding="utf-8") as file:
                file.write(text)
        found, counted = problems(tree)
        check_untracked(planted, problems, tree)
    assert counted == len(planted), (counted, len(planted))
    for path, (_, expected) in planted.items():
        here = [finding for finding in found if finding.split(":")[0] == path]
        if expected is None:
            assert not here, here
        else:
            assert len(here) == 1 and expected in here[0], (path, expected, here)
    print(f"{len(planted)} planted files judged as expected")


def check_untracked(planted, problems, tree):
    """Where git knows the tree, what it does not track is not read: a run may leave anything between the sources."""
    def git(*arguments):
        subprocess.run(["git", "-C", tree, *arguments], check=True, capture_output=True)
    try:
        git("init", "-q")
    except OSError:
        return  # there is no git
    good, bad = (next(path for path, (_, expected) in planted.items() if (expected is None) == wanted) for wanted in (True, False))
    git("add", good)
    assert problems(tree) == ([], 1), (good, problems(tree))
    git("add", bad)
    found, counted = problems(tree)
    assert counted == 2 and found, (bad, found)


def run(usage, planted, problems):
    """TREE or --self-test; exits with 1 where there are findings."""
    if len(sys.argv) != 2:
        sys.exit(usage)
    if sys.argv[1] == "--self-test":
        return self_test(planted, problems)
    found, counted = problems(sys.argv[1])
    for finding in found:
        print(finding)
    if counted < 50:
        sys.exit(f"only {counted} files were read: this is not the tree")
    print(f"{counted} files read, {len(found)} problems")
    sys.exit(1 if found else 0)
