# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pages of the repository as pages of the site: links are turned so that they lead somewhere in both.

A link of a page in docs/ is relative to that page, so that a forge follows it. In the site a link to a page or a picture in
docs/ stays, one to an example scene leads to its place in the gallery, and one to any other file to a page that shows it."""
import os
import posixpath
import re

FENCE = re.compile(r"^(\s*)(```+|~~~+)")
# A link or a picture with its target, or a piece of code: whichever comes first in a line.
PIECE = re.compile(r"(?P<link>\]\((?P<target>[^)\s]+)(?P<title>\s+\"[^\"]*\")?\))|(?P<code>(?<!`)`[^`\n]+`(?!`))|(?P<open>\[)")
ITEM = re.compile(r"^\s*([-*]|\d+\.)\s+")
GENERATED = {"components": "components/README.md", "tools/command": "command.md", "tools/command/words/topics.txt": "words.md"}
WIDE = 11  # bars in a row of a table that wants the room of the headings beside it
LANGUAGES = {".xml": "xml", ".py": "python", ".cpp": "cpp", ".h": "cpp", ".sh": "sh", ".cmake": "cmake", ".txt": "text"}


def slug(heading):
    """The anchor of a heading, as forges and the site make it."""
    text = re.sub(r"[`*]", "", heading).strip().lower()
    return re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", text))


class Repository:
    """The tree at `root`, and the pages that a site of it has: site path (components/X.md) -> text."""

    def __init__(self, root):
        self.root = root
        self.pages = {}          # site path: text, all links turned
        self.components = {}     # name: site path
        self.scenes = {}         # scenes/examples/x.xml: gallery.md#anchor
        self.missing = []        # what a link leads to and is not there

    # ---- where things are in the site ----

    def place(self, path):
        """The site path of a file or folder of the repository, made when it is the first link to it."""
        if path in self.scenes:
            return self.scenes[path]
        if path in GENERATED:  # the site has a page for it
            return GENERATED[path]
        if path.startswith("docs/"):
            return path[len("docs/"):]
        full = os.path.join(self.root, path)
        if os.path.isdir(full) and os.path.exists(os.path.join(full, "README.md")):
            path, full = posixpath.join(path, "README.md"), os.path.join(full, "README.md")
        site = "sources/" + path + ("" if path.endswith(".md") else ".md")
        if site not in self.pages:
            self.pages[site] = ""  # it may link to itself
            self.pages[site] = self._folder(path, site) if os.path.isdir(full) else self._file(path, site)
        return site

    def _folder(self, path, site):
        lines = [f"# {path}", ""]
        for name in sorted(os.listdir(os.path.join(self.root, path))):
            full = os.path.join(self.root, path, name)
            if os.path.isfile(full) and not name.startswith("."):
                lines.append(f"- [{name}]({self.relative(self.place(posixpath.join(path, name)), site)})")
        return "\n".join(lines) + "\n"

    def _file(self, path, site):
        with open(os.path.join(self.root, path), encoding="utf-8", errors="replace") as file:
            text = file.read()
        if path.endswith(".md"):
            return self.turned(text, path, site)
        language = LANGUAGES.get(posixpath.splitext(path)[1], "python" if text.startswith("#!/usr/bin/env python3") else "text")
        return f"# {posixpath.basename(path)}\n\n`{path}` of the source tree.\n\n``````{language}\n{text.rstrip()}\n``````\n"

    @staticmethod
    def relative(target, site):
        """A link from the page at `site` to the site path `target` (with #anchor)."""
        path, _, anchor = target.partition("#")
        path = posixpath.relpath(path, posixpath.dirname(site) or ".")
        return path + ("#" + anchor if anchor else "")

    # ---- pages ----

    def add_docs(self):
        """Every page of docs/; other files of docs/ are copied by the caller."""
        for folder, folders, names in os.walk(os.path.join(self.root, "docs")):
            folders.sort()
            for name in sorted(names):
                if name.endswith(".md"):
                    path = os.path.relpath(os.path.join(folder, name), self.root).replace(os.sep, "/")
                    with open(os.path.join(self.root, path), encoding="utf-8") as file:
                        self.add(path, path[len("docs/"):], file.read())

    def add(self, path, site, text):
        """A page whose links are written as from `path` of the repository."""
        wide = max((line.count("|") for line in text.split("\n") if line.startswith("|")), default=0) >= WIDE
        self.pages[site] = ("---\nhide:\n  - toc\n---\n" if wide else "") + self.turned(text, path, site)

    def turned(self, text, path, site):
        """The text with the links of the site, and blank lines where Python-Markdown wants them before lists."""
        lines, fence = [], None
        for line in text.split("\n"):
            mark = FENCE.match(line)
            if mark and fence is None:
                fence = mark.group(2)
            elif mark and line.strip().startswith(fence):
                fence = None
                lines.append(line)
                continue
            if fence is None:
                before = lines[-1] if lines else ""
                if ITEM.match(line) and before.strip() and not ITEM.match(before) and not before.startswith(" "):
                    lines.append("")
                line = self._line(line, path, site)
            lines.append(line)
        return "\n".join(lines)

    def _line(self, line, path, site):
        depth = 0  # inside the text of a link, where no other link may be

        def turn(match):
            nonlocal depth
            if match.group("open"):
                depth += 1
                return "["
            if match.group("link"):
                depth = max(0, depth - 1)
                return f"]({self._target(match.group('target'), path, site)}{match.group('title') or ''})"
            return match.group("code") if depth or line.startswith("#") else self._code(match.group("code"), site)

        return PIECE.sub(turn, line)

    def _code(self, code, site):
        """A component or a scene that is named in the text gets a link."""
        word = code.strip("`")
        target = self.components.get(word)
        if target is None and re.fullmatch(r"scenes/[\w/]+\.xml", word) and os.path.exists(os.path.join(self.root, word)):
            target = self.place(word)
        return f"[{code}]({self.relative(target, site)})" if target and target != site else code

    def _target(self, target, path, site):
        if "://" in target or target.startswith(("#", "mailto:")):
            return target
        file, _, anchor = target.partition("#")
        file = posixpath.normpath(posixpath.join(posixpath.dirname(path), file))
        if not os.path.exists(os.path.join(self.root, file)):
            self.missing.append(f"{path}: {target}")
            return target
        place = self.place(file)
        return self.relative(place + ("#" + anchor if anchor else ""), site)
