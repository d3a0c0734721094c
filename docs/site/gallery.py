# SPDX-License-Identifier: LGPL-2.1-or-later
"""The gallery: docs/gallery.md with a picture, numbers and the source of every example, all made by running it.

A section says what is shown by a comment that pages do not show:
    <!-- scene: scenes/examples/organ.xml steps=200 picture="--field vonMises" page -->
`picture` are options for `stroma picture`; with `page` there is also a page that plays the run by itself."""
import json
import os
import re
import shlex
import subprocess
import tempfile

from repository_links import slug

COMMENT = re.compile(r"<!-- scene: (\S+)(.*?)-->")
HEADING = re.compile(r"^## (.+)$")


class GalleryError(Exception):
    """An example that cannot be shown."""


def shown_scenes(text):
    """Scene -> anchor of its section, in the order of the page."""
    scenes, heading = {}, ""
    for line in text.split("\n"):
        match = HEADING.match(line)
        heading = match.group(1) if match else heading
        match = COMMENT.search(line)
        if match:
            scenes[match.group(1)] = slug(heading)
    return scenes


def examples(root):
    """All scenes that the gallery has to show."""
    folder = os.path.join(root, "scenes", "examples")
    return sorted("scenes/examples/" + name for name in os.listdir(folder) if name.endswith(".xml"))


class Gallery:
    """Fills the gallery of the site whose source is in `folder`, with the command `stroma`."""

    def __init__(self, root, stroma, folder, say, tabs, draft=False):
        self.root, self.stroma, self.folder, self.say = root, os.path.abspath(stroma), folder, say
        self.tabs, self.draft = tabs, draft

    def filled(self, text):
        """The page with what belongs behind every comment."""
        os.makedirs(os.path.join(self.folder, "gallery"), exist_ok=True)
        not_shown = set(examples(self.root)) - set(shown_scenes(text))
        if not_shown:
            raise GalleryError("docs/gallery.md does not show " + ", ".join(sorted(not_shown)))
        sections = re.split(r"(?m)^(?=## )", text)
        return "".join(self._section(section) for section in sections)

    def _section(self, section):
        match = COMMENT.search(section)
        if not match:
            return section
        scene, options = match.group(1), dict(
            (word.split("=", 1) + [True])[:2] for word in shlex.split(match.group(2)))
        return section.rstrip() + "\n\n" + self._shown(scene, options) + "\n"

    def _shown(self, scene, options):
        name, steps = os.path.splitext(os.path.basename(scene))[0], "1" if self.draft else options.get("steps", "100")
        self.say(f"{scene}, {steps} steps")
        with tempfile.TemporaryDirectory() as scratch:
            plan = self._json(["explain", os.path.join(self.root, scene), "--json"], scratch)
            run = self._json(["run", os.path.join(self.root, scene), "-n", steps, "--quiet", "--json", "--no-record"], scratch)
            picture = os.path.join(self.folder, "gallery", name + ".png")
            small = ("--size", "320x240") if self.draft and "--size" not in options.get("picture", "") else ()
            self._call(["picture", os.path.join(self.root, scene), "-n", steps, "-o", picture, *small,
                        *shlex.split(options.get("picture", ""))], scratch)
            link = ""
            if "page" in options:
                page = os.path.join(self.folder, "gallery", name + ".html")
                every = options.get("every", str(max(1, int(steps) // 100)))
                self._call(["view", os.path.join(self.root, scene), "--export", page, "-n", steps, "--every", every,
                            *shlex.split(options.get("fields", ""))], scratch)
                link = f" · [turn it and play it](gallery/{name}.html){{target=_blank}}"
        with open(os.path.join(self.root, scene), encoding="utf-8") as file:
            source = file.read().rstrip()
        size = "{ width=640 }"
        shown = f"![{name} after {steps} steps](gallery/{name}.png){size}"
        lines = [shown, "", self._numbers(plan, run) + link, "",
                 f'??? note "{scene}"', "", *("    " + line if line else "" for line in self.tabs.of(source)), ""]
        return "\n".join(lines)

    @staticmethod
    def _numbers(plan, run):
        steps = max(1, run["steps"])
        parts = [*counted(plan), f"{steps:,} step{'s' if steps > 1 else ''} of {run['simulated_time'] / steps:.3g} s",
                 f"{duration(run['ms_per_step']['median'])} per step"]
        farthest = max((one["distance"] for one in run["greatest_displacements"]), default=0)
        unit = (run["units"] or {}).get("length", "")  # of no unit where a scene has no system of units
        parts.append("largest displacement " + (f"{1000 * farthest:.3g} mm" if unit == "m" else f"{farthest:.3g} {unit}".rstrip()))
        return '<span class="numbers" markdown>' + " · ".join(parts) + "</span>"

    def _json(self, arguments, scratch):
        return json.loads(self._call(arguments, scratch))

    def _call(self, arguments, scratch):
        done = subprocess.run([self.stroma, *arguments], cwd=scratch, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            raise GalleryError(f"stroma {' '.join(arguments)} ended with {done.returncode}:\n{done.stderr or done.stdout}")
        return done.stdout


def duration(milliseconds):
    """In the unit that suits it."""
    return f"{1000 * milliseconds:.3g} microseconds" if milliseconds < 0.01 else f"{milliseconds:.3g} ms"


def counted(plan):
    """Nodes and cells of a scene, from `stroma explain --json`; cells of a mesh that is cut into others do not count."""
    nodes = sum(system["nodes"] for system in plan["systems"])
    for kind in ("tetrahedra", "hexahedra", "quads", "triangles", "edges"):
        cells = [mesh[kind] for mesh in plan["meshes"] if mesh.get(kind)]
        if cells:
            return [f"{nodes:,} nodes", f"{' + '.join(f'{int(number):,}' for number in cells)} {kind}"]
    return [f"{nodes:,} nodes"]
