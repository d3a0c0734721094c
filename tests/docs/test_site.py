#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the documentation site and checks it: every link, anchor and picture leads somewhere, nothing is fetched from elsewhere,
every component and example has its page, and in a browser no page is wider than its window and the search finds words without
a server. Usage: test_site.py TREE BUILD, or test_site.py --self-test"""
import contextlib
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse

SKIPPED = 77
# What a script and a comment hold is no tag, and the parser need not see text and tags without these: pages of source code are long.
NO_TAGS = re.compile(r"<!--.*?-->|(<script\b[^>]*>).*?(?=</script>)", re.S | re.I)
TAG = re.compile(r"""<[a-zA-Z](?:=\s*"[^"]*"|=\s*'[^']*'|[^>])*?>""")  # a quotation mark elsewhere is a letter as others
WANTED = re.compile(r"\s(?:href|src|id|name)\b", re.I)
SCRIPT = re.compile(r"<script\b", re.I)


class Reader(html.parser.HTMLParser):
    """Links, anchors and what a page loads."""

    def __init__(self):
        super().__init__()
        self.links, self.loads, self.anchors, self.pictures = [], [], set(), []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors.update(value for key, value in attrs if key in ("id", "name") and value)
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag == "img":
            self.pictures.append((given.get("src", ""), given.get("alt", "")))
        if tag in ("script", "img", "source", "iframe") and given.get("src"):
            self.loads.append(given["src"])
        if tag == "link" and given.get("rel") in ("stylesheet", "icon", "preconnect", "preload") and given.get("href"):
            self.loads.append(given["href"])


def page_files(site):
    """Paths of the pages that mkdocs made, sorted."""
    found = [os.path.relpath(os.path.join(folder, name), site) for folder, _, names in os.walk(site) for name in names if name.endswith(".html")]
    return sorted(path for path in found if not path.startswith("gallery" + os.sep))  # those play by themselves


def read_pages(site):
    """Path -> Reader of every page."""
    pages = {}
    for path in page_files(site):
        reader = Reader()
        with open(os.path.join(site, path), encoding="utf-8") as file:
            for tag in TAG.findall(NO_TAGS.sub(r"\1", file.read())):
                if WANTED.search(tag):
                    reader.feed(tag + "</script>" * bool(SCRIPT.match(tag)))
        pages[path] = reader
    return pages


def problems(site):
    """What is wrong with the files of the site."""
    pages, found = read_pages(site), []
    for path, page in sorted(pages.items()):
        for link in page.loads:
            if "://" in link or link.startswith("//"):
                found.append(f"{path} fetches {link}")
            elif not link.startswith("data:") and not os.path.exists(local(site, path, link)[0]):
                found.append(f"{path} loads {link}, which is not there")
        found += [f"{path}: the picture {source} has no words for those who do not see it" for source, words in page.pictures if not words]
        for link in page.links:
            if "://" in link or link.startswith("mailto:"):
                continue
            target, anchor = local(site, path, link)
            if path == "404.html":  # its links start at the root of a server
                continue
            if not os.path.exists(target):
                found.append(f"{path} links to {link}, which is not there")
            elif anchor and target.endswith(".html"):
                other = pages.get(os.path.relpath(target, site))
                if other and anchor not in other.anchors:
                    found.append(f"{path} links to {link}, which has no such heading")
    return found, len(pages)


def local(site, path, link):
    """(file, anchor) of a link on a page."""
    parts = urllib.parse.urlsplit(link)
    name = urllib.parse.unquote(parts.path)
    base = site if name.startswith("/") else os.path.dirname(os.path.join(site, path))
    target = os.path.normpath(os.path.join(base, name.lstrip("/"))) if name else os.path.join(site, path)
    return os.path.join(target, "index.html") if os.path.isdir(target) else target, urllib.parse.unquote(parts.fragment)


def missing_pages(tree, build, site):
    """Components and examples without a place in the site."""
    stroma = os.path.join(build, "bin", "stroma")
    components = json.loads(subprocess.run([stroma, "list", "--json"], capture_output=True, text=True, check=True).stdout)
    found = [f"no page of {c['name']}" for c in components
             if not os.path.exists(os.path.join(site, "components", c["module"], c["name"] + ".html"))]
    if os.path.isdir(os.path.join(build, "python", "stroma")):
        for c in components:
            with open(os.path.join(site, "components", c["module"], c["name"] + ".html"), encoding="utf-8") as file:
                page = file.read()
            if 'id="example"' in page and ">Python</label>" not in page:
                found.append(f"no Python beside the example of {c['name']}")
    with open(os.path.join(site, "gallery.html"), encoding="utf-8") as file:
        gallery = file.read()
    for name in sorted(os.listdir(os.path.join(tree, "scenes", "examples"))):
        stem, ending = os.path.splitext(name)
        if ending == ".xml" and (f"scenes/examples/{name}" not in gallery
                                 or not os.path.exists(os.path.join(site, "gallery", stem + ".png"))):
            found.append(f"the gallery does not show {name}")
    return found


# ---- in a browser ----

WIDTHS, HEIGHT = (1280, 390), 300  # of the window: what is wider than it is so at any height, and less is drawn of a low one
TOO_WIDE = 20  # seconds after which a page that is wider than its window stays so
FEW = ["index.html", "first_scene.html", "gallery.html", "words.html", "validation.html", "benchmarks.html", "limits.html",
       "stability/force_fields.html", "experiments/truth_cube.html", "developer.html", "components/index.html",
       "components/elasticity/TetrahedronFEMForceField.html", "command.html"]


def other_pages(site):
    """All but these and sources, with one component per family."""
    found, families = set(), {path.split("/")[1] for path in FEW if path.count("/") == 2}
    for path in page_files(site):
        parts = path.split("/")
        if parts[0] in ("sources", "404.html") or path in FEW:
            continue
        if parts[0] == "components" and len(parts) == 3 and parts[2] != "index.html":
            if parts[1] in families:
                continue
            families.add(parts[1])
        found.add(path)
    return sorted(found)


@contextlib.contextmanager
def almost_nothing_to_search(site):
    """Each page reads the index of all pages anew, which takes longer than everything else of it."""
    path = os.path.join(site, "search", "offline.js")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    head, tail = "var __search = {index: Promise.resolve(", "),\n"
    assert text.startswith(head) and tail in text
    index, end = json.JSONDecoder().raw_decode(text, len(head))
    assert text[end:].startswith(tail) and len(index["docs"]) > 100
    with open(path, "w", encoding="utf-8") as file:
        file.write(head + json.dumps({**index, "docs": index["docs"][:1]}) + text[end:])
    try:
        yield
    finally:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


def browse(tree, site):
    """Problems that only a browser sees."""
    sys.path.insert(0, os.path.join(tree, "tests", "view"))
    from browser import Browser, skip_without_browser  # pylint: disable=import-outside-toplevel
    skip_without_browser()
    found = []

    def look(pages, widths=WIDTHS[:1]):
        for page in pages:
            browser.driver.get("file://" + os.path.join(site, page))
            for width in widths:
                if widths[1:]:
                    browser.size(width, HEIGHT, touch=width < 600)
                try:  # a page follows its window in its own time: with scripts, and what they move
                    browser.until(lambda: browser.script("document.documentElement.scrollWidth <= window.innerWidth"), "a page within its window",
                                  seconds=TOO_WIDE)
                except AssertionError:
                    wide, window = browser.script("[document.documentElement.scrollWidth, window.innerWidth]")
                    found.append(f"{page} is {wide} pixels wide in a window of {window}")
            if browser.script("[...document.images].some(i => i.complete && !i.naturalWidth)"):
                found.append(f"{page} has a picture that does not show")

    def run_scripts(wanted):
        browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": not wanted})

    with Browser() as browser:
        with almost_nothing_to_search(site):
            look(FEW, WIDTHS)
            browser.size(WIDTHS[0], HEIGHT)
            run_scripts(False)  # they are the same on all pages, and take longer than the page
            look(other_pages(site))
            run_scripts(True)
        browser.driver.get("file://" + os.path.join(site, "index.html") + "?q=BoxROI")
        browser.until(lambda: "BoxROI.html" in browser.script("document.querySelector('.md-search-result').innerHTML"),
                     "the search finds a component")
        errors = browser.complaints()
        found += [f"the browser says: {error}" for error in errors if "favicon" not in error]
    return found


def check_refusals(tree):
    """A folder with anything but a site in it is left as it is."""
    with tempfile.TemporaryDirectory() as folder:
        full, new = os.path.join(folder, "full"), os.path.join(folder, "new")
        os.mkdir(full)
        with open(os.path.join(full, "kept.txt"), "w", encoding="ascii") as file:
            file.write("mine")
        environment = dict(os.environ, HOME=os.path.join(folder, "home"))
        os.mkdir(environment["HOME"])
        # Without mkdocs the script ends before it looks at anything.
        for out in () if not shutil.which("mkdocs") else (full, os.path.join(full, "kept.txt"), tree, os.path.dirname(tree), os.path.join(tree, "docs"), environment["HOME"], folder):
            made = subprocess.run([sys.executable, os.path.join(tree, "docs", "site", "build"), out, "--stroma", "/no/command"],
                                  capture_output=True, text=True, check=False, env=environment)
            assert made.returncode == 2 and out in made.stderr, (out, made)
        assert os.listdir(full) == ["kept.txt"] and not os.listdir(environment["HOME"])
        sys.path.insert(0, os.path.join(tree, "docs", "site"))
        from output_folder import mark, refusal  # pylint: disable=import-outside-toplevel
        assert refusal(new, tree) is None and refusal(environment["HOME"], tree) is None  # not there; empty
        mark(new)
        with open(os.path.join(new, "index.html"), "w", encoding="ascii"):
            pass
        assert refusal(new, tree) is None and refusal(full, tree)


def self_test():
    """Planted mistakes are found."""
    check_refusals(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
    with tempfile.TemporaryDirectory() as site:
        with open(os.path.join(site, "a.html"), "w", encoding="utf-8") as file:
            file.write('<h1 id="top">A</h1><a href="b.html">b</a><a title="a > b"\nhref=#nowhere>n</a><a href="a.html#top">t</a><img src="c.png">'
                       '<script>"<a href=\\"d.html\\">"</script><!-- <a href="e.html">e</a> --><script src="https://host/x.js"></script>'
                       '<a href="https://host/">out</a><A HREF=f.html>f</A><a href="g.html" data-x=it\'s>g</a><SCRIPT>"<a href=h.html>"</SCRIPT>')
        found, count = problems(site)
        expected = ("links to b.html", "links to f.html", "links to g.html", "no such heading", "loads c.png", "has no words", "fetches https://host/x.js")
        assert count == 1 and len(found) == len(expected), found
        assert all(any(words in line for line in found) for words in expected), found
    print("planted mistakes of a site are found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    tree, build = (os.path.abspath(path) for path in sys.argv[1:3])
    if not shutil.which("mkdocs"):
        print("skipped: there is no mkdocs (packages mkdocs and mkdocs-material)")
        sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory(prefix="stroma_site_") as folder:
        site = os.path.join(folder, "site")
        made = subprocess.run([sys.executable, os.path.join(tree, "docs", "site", "build"), site, "--draft", "--stroma",
                               os.path.join(build, "bin", "stroma")], capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stderr[-4000:]
        found, count = problems(site)
        found += missing_pages(tree, build, site)
        assert not found, "\n".join(found)  # also where there is no browser
        found = browse(tree, site)
        assert not found, "\n".join(found)
        print(f"{count} pages; every link, anchor and picture leads somewhere, and nothing is fetched")


if __name__ == "__main__":
    main()
