#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Contact in the page of `stroma view`: colours, arrows and numbers, and tools that the pointer moves.
Usage: test_contact_page.py TREE STROMA [names of tests]"""
import sys
import tempfile
import unittest

import test_page  # the browser and the cases' base
from test_page import PageTest, STROMA, Server, setUpModule, tearDownModule  # pylint: disable=unused-import
from test_contact import SCENE
from test_protocol import write

SHOWN = "window.stroma.store.shown"


class ContactPage(PageTest):
    """A block, a tool on a frame and one that is an obstacle."""

    def setUp(self):
        super().setUp()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.scene = write(self.folder.name, "tools.xml", SCENE)

    def open(self, viewed):
        browser = test_page.browser
        browser.open(viewed.address)
        self.shows_bodies()
        return browser

    def drag(self, browser, begin, by, steps=6):
        """Drags from a place; after each piece of the way a step is made. Ends with the pointer up."""
        (x, y), (dx, dy) = begin, by
        browser.pointer("down", x, y)
        for k in range(1, steps + 1):
            browser.pointer("move", x + dx * k / steps, y + dy * k / steps)
            step = browser.script(f"{SHOWN}.header.step")
            browser.click("step")
            browser.until(f"{SHOWN}.header.step > {step} && window.stroma.frameDrawn === {SHOWN}.header.frame", "a step with the tool")
        browser.pointer("up", x + dx, y + dy)

    def place(self, browser, expression):
        """Where a point of the world is on the screen."""
        return browser.script(f"(p => {{ const {{x, y}} = window.stroma.stage.toScreen(p); return [x, y]; }})({expression})")

    def test_a_tool_is_dragged_and_what_it_does_is_seen(self):
        """The ball is dragged down by more than it can go; the block has arrows, the colour of a pressure and a table of forces."""
        with Server(STROMA, self.scene, "--paused") as viewed:
            browser = self.open(viewed)
            before = browser.still()
            browser.click("tab-contact")
            browser.press("2")
            ball = self.place(browser, "[0.02, 0, 0.018]")
            self.drag(browser, ball, (0, 120))
            offset, moved = browser.script(f"[{SHOWN}.header.offsets[0], {SHOWN}.header.moved[0]]")
            self.assertLess(offset[2], -0.01)
            self.assertLess(moved[2], -0.003)
            browser.until(f"{SHOWN}.header.contacts && {SHOWN}.header.contacts[0].wrenches[2] < -0.01", "the force of the ball")
            self.assertEqual(browser.script(f"{SHOWN}.header.contacts[0].crossings"), 0)
            self.assertGreater(browser.script(f"{SHOWN}.header.contacts[0].smallestGap"), 0)
            # numbers are those of the frame
            row = browser.script("document.querySelector('#panel-contact tr[data-force]').dataset.force").split()
            self.assertEqual([float(value) for value in row], browser.script(f"{SHOWN}.header.contacts[0].wrenches.slice(0, 3)"))
            plain = browser.still()
            self.assertGreater(test_page.difference(plain, before), 0.001)
            browser.click("show-contacts")
            browser.until("window.stroma.stage.contacts.arrows.geometry.instanceCount > 0", "arrows")
            with_arrows = browser.still()
            self.assertGreater(test_page.difference(with_arrows, plain), 0.0001)
            key = browser.script("window.stroma.store.fields.find(f => f.name === 'pressures' && f.body === window.stroma.store.contacts[0].body)")
            browser.choose("contact-field", f"{key['name']}|{key['on']}|{key['unit']}")
            browser.until(f"window.stroma.store.values.has({key['id']}) && !document.getElementById('legend').hidden", "the pressure")
            self.assertIn("Contact pressure", browser.find("legend").text)
            self.assertGreater(test_page.difference(browser.still(), with_arrows), 0.01)

    def test_a_tool_on_a_frame_is_taken_by_its_surface(self):
        """A rigid tool is taken where the pointer is, follows it, and stops at the block."""
        with Server(STROMA, self.scene, "--paused") as viewed:
            browser = self.open(viewed)
            browser.press("2")
            frame = browser.script("window.stroma.store.bodies.find(b => b.path === '/tool/frame').index")
            tip = browser.script("window.stroma.store.bodies.find(b => b.path === '/tool/tip/dofs').index")
            start = browser.positions(frame)[0]
            self.drag(browser, self.place(browser, "[-0.02, -0.006, 0.022]"), (0, 150), 10)
            self.assertLess(browser.positions(frame)[0][2], start[2] - 0.001, "the frame has not followed")
            self.assertGreater(browser.positions(tip)[:, 2].max(), 0, "it has gone into the block")
            browser.click("tab-contact")
            browser.until(f"{SHOWN}.header.contacts && window.stroma.frameDrawn === {SHOWN}.header.frame", "the numbers")
            self.assertEqual(browser.script(f"{SHOWN}.header.contacts[0].crossings"), 0)
            browser.until(f"{SHOWN}.header.hands.length === 0", "the tool to be let go")

    def test_a_scene_without_contact_says_so(self):
        with Server(STROMA, test_page.example("organ.xml"), "--paused") as viewed:
            browser = self.open(viewed)
            browser.click("tab-contact")
            self.assertIn("Nothing in this scene finds contacts", browser.css("#panel-contact").text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
