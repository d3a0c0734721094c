# SPDX-License-Identifier: LGPL-2.1-or-later
"""The files of the tree, as checks of it read them: those that git tracks, not what runs and people have left between them."""
import os
import subprocess

LEFT_OUT = {".git", "results", "__pycache__"}  # where git cannot say what is of the tree; and folders that begin with "build"


def _tracked(tree):
    """Paths that git knows and that are there; None where there is no git, or the tree is none of its own."""
    try:  # whoever owns the files, they are only listed
        listed = subprocess.run(["git", "-c", "safe.directory=*", "-C", tree, "ls-files", "-z"], capture_output=True, check=True)
        top = subprocess.run(["git", "-c", "safe.directory=*", "-C", tree, "rev-parse", "--show-prefix"], capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    if top.stdout.strip() or not listed.stdout:
        return None
    paths = set(listed.stdout.decode("utf-8", "surrogateescape").split("\0")) - {""}
    return [path for path in paths if os.path.isfile(os.path.join(tree, path))]


def _walked(tree):
    for folder, folders, names in os.walk(tree):
        folders[:] = [name for name in folders if name not in LEFT_OUT and not name.startswith("build")]
        for name in names:
            if name != ".git":  # of a linked work tree
                yield os.path.relpath(os.path.join(folder, name), tree).replace(os.sep, "/")


def tree_files(tree):
    """Paths below `tree`, sorted, with slashes."""
    tracked = _tracked(tree)
    return sorted(_walked(tree) if tracked is None else tracked)
