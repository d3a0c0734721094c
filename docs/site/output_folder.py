# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where a site may be made. mkdocs deletes what is in its folder, so only a new, an empty or a former site's folder will do."""
import os

MARKER = ".stroma-site"  # hidden: mkdocs keeps such files


def refusal(out, root, home=None):
    """Why no site may be made in `out`, or None. `root` is the source tree."""
    out, root = os.path.realpath(out), os.path.realpath(root)
    home = os.path.realpath(home or os.path.expanduser("~"))
    for kept, what in ((root, "the source tree"), (home, "your home folder")):
        if os.path.commonpath([out, kept]) == out:
            return f"{out} is {what}, or holds it: what is in the folder of a site is deleted. Name a new folder"
    if not os.path.lexists(out):
        return None
    if not os.path.isdir(out):
        return f"{out} is a file; a new folder was expected"
    if os.listdir(out) and not os.path.isfile(os.path.join(out, MARKER)):
        return (f"{out} is not empty, and no site was made there before (it has no {MARKER}): what is in it would be deleted. "
                "Name a new or an empty folder")
    return None


def mark(out):
    """Makes the folder, as one of a site: what is in it may be replaced."""
    os.makedirs(out, exist_ok=True)
    with open(os.path.join(out, MARKER), "w", encoding="ascii") as file:
        file.write("docs/site/build made this folder; the next site made here replaces what is in it\n")
