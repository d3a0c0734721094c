# SPDX-License-Identifier: LGPL-2.1-or-later
"""Beside every scene in XML the same scene in Python, as stroma.to_python() writes it, in tabs of the page. Nothing is written twice.

A block of a page gets one when it is a whole scene that Stroma reads: no part of one, none that includes files, and none that the
page shows because it is refused."""
import os
import re
import sys

BLOCK = re.compile(r"(?m)^(?P<before><!--[^\n]*-->\n)?```xml(?P<rest>[^\n]*)\n(?P<scene>.*?)^```$", re.S)
RUN = ["simulation = stroma.load(root)", "simulation.run(100)"]


class PythonTabs:
    """Needs the Python module that was built or installed with the command `stroma`; without it scenes are shown in XML alone."""

    def __init__(self, stroma, say):
        built = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(stroma))), "python")
        sys.path[:0] = [built] if os.path.isdir(built) else []
        try:
            import stroma as module
            self.module = module
        except ImportError:
            self.module = None
            say("no Python beside the scenes: the module stroma is not there")

    def program(self, scene):
        """The lines of Python; None: there are none."""
        if self.module is None or "<include" in scene or not re.match(r"\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*)*<Node\b", scene, re.S):
            return None
        try:
            tree = self.module.from_xml_text(scene)
        except self.module.StromaError:
            return None
        return self.module.to_python(tree).rstrip().split("\n") + ["", *RUN]

    def of(self, scene, title=""):
        """The lines of Markdown that show a scene."""
        def block(language, name, lines):
            return [f"```{language}" + (f' title="{name}"' if name else ""), *lines, "```"]

        shown = block("xml", title, scene.rstrip("\n").split("\n"))
        program = self.program(scene)
        if program is None:
            return shown
        python = block("python", os.path.splitext(title)[0] + ".py" if title else "", program)
        lines = ['=== "XML"', "", *("    " + line for line in shown), "", '=== "Python"', "", *("    " + line for line in python)]
        return [line.rstrip() for line in lines]

    def on(self, text):
        """A page with tabs."""
        def turned(match):
            before, rest = match["before"] or "", match["rest"]
            title = re.fullmatch(r'\s*(?:title="([^"]*)")?\s*', rest)
            if title is None or before.startswith(("<!-- refused", "<!-- part of")):
                return match[0]
            return before + "\n".join(self.of(match["scene"], title[1] or ""))

        return BLOCK.sub(turned, text)
