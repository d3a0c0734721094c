#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of `stroma view` in Chromium: what the example scenes have to draw is drawn, hands reach in, files are written, and the
page survives the loss of its server. Usage: test_page.py TREE STROMA [names of tests]"""
import glob
import io
import os
import re
import signal
import sys
import tempfile
import unittest

from browser import Browser, Image, Keys, Proxy, difference, skip_without_browser

skip_without_browser()

import numpy  # pylint: disable=wrong-import-position

import server  # pylint: disable=wrong-import-position
from test_protocol import BLOCK, command, example, hash_of_run  # pylint: disable=wrong-import-position

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])
EXAMPLES = sorted(glob.glob(os.path.join(TREE, "scenes", "examples", "*.xml")))
WATCHED = "window.stroma.store.status"
browser = None


def setUpModule():
    """Starting a browser costs more than any case."""
    global browser  # pylint: disable=global-statement
    browser = Browser()


def tearDownModule():
    """Ends it."""
    browser.close()


class Server(server.Server):
    """The page is left before its server ends: it would complain, rightly."""

    def end(self):
        browser.leave()
        PageTest.complaints += browser.complaints()
        return super().end()

    def __exit__(self, kind, error, trace):
        if kind is not None:
            browser.leave()
        super().__exit__(kind, error, trace)


class PageTest(unittest.TestCase):
    """A case leaves the browser as it found it, and the console without complaints."""

    quiet = True
    complaints = []

    def setUp(self):
        browser.complaints()
        PageTest.complaints = []

    def tearDown(self):
        PageTest.complaints += browser.complaints()
        browser.leave()
        browser.size()
        browser.scheme("light")
        if self.quiet:
            self.assertEqual(PageTest.complaints, [], "the console")

    def shows_bodies(self):
        """Something is drawn that has shades: more than a few pixels, less than all."""
        def is_drawn():
            part, colours = browser.drawn()
            return 0.01 < part < 0.98 and colours > 8
        browser.until(is_drawn, "bodies that are drawn and shaded")


def what_is_drawn(viewed):
    """What the page has to draw of a server's scene, and how large and how fast it is, in powers of ten; asked without the browser."""
    packet = viewed.page().scene
    shown = {("bodies", min(len(packet["bodies"]), 3)), ("dt", round(numpy.log10(packet["dt"])))}
    for number, body in enumerate(packet["bodies"]):
        arrays = tuple(name for name in ("triangles", "edges", "points", "springs") if len(packet.arrays.get(f"{number}.{name}", ())))
        shown.add(("arrays", arrays, body["interactive"]))
        shown.add(("cells", *(kind for kind, count in body["cells"].items() if count)))
        shown.add(("solids", *(kind for kind in ("beams", "balls", "frames") if body[kind])))
        shown.add(("size", round(numpy.log10(body["size"]))))
    return shown


class EveryExample(PageTest):
    """One server a scene. Those are opened that have what none before had: test_protocol.py has the messages of all."""

    def test_opens_draws_runs_pauses_and_resets(self):
        seen, opened = set(), 0
        for scene in EXAMPLES:
            with self.subTest(os.path.basename(scene)), server.Server(STROMA, scene, "--paused") as viewed:
                shown = what_is_drawn(viewed)
                if shown - seen:
                    seen |= shown
                    opened += 1
                    self.use(viewed, os.path.basename(scene))
        self.assertGreater(opened, 8)

    def use(self, viewed, name):
        """What a person does who sees a scene for the first time."""
        viewed.pages.pop().socket.close()
        browser.open(viewed.address)
        browser.until(f"{WATCHED}.clients === 1", "the page that asked to be gone")
        self.assertNotIn("token", browser.driver.current_url)
        self.assertIn(name, browser.driver.title)
        self.shows_bodies()
        bodies = browser.script("window.stroma.store.bodies.length")
        start = [browser.positions(body) for body in range(bodies)]
        for step in range(1, 4):
            browser.click("step")
            browser.until(f"window.stroma.store.shown.header.step >= {step} || {WATCHED}.ended", "a step")
        self.assertEqual(browser.script(f"{WATCHED}.ended"), "")
        browser.until(lambda: max(abs(browser.positions(body) - start[body]).max() for body in range(bodies)) > 0, "a movement")
        browser.choose("pace", "fast")
        browser.until(f"{WATCHED}.pace === 'fast'", "the pace")
        browser.click("run")
        browser.until("window.stroma.store.shown.header.step > 4", "steps of the run")
        # a scene of quick steps may have come to an end of its own by now
        browser.script("document.querySelector('[data-test=pause]')?.click()")
        browser.until(f"!{WATCHED}.running", "the pause")
        browser.click("reset")
        browser.until("window.stroma.store.shown.header.step === 0 && window.stroma.store.newest === window.stroma.store.shown", "the reset")
        browser.until(lambda: all((browser.positions(body) == start[body]).all() for body in range(bodies)), "the start")
        browser.leave()
        PageTest.complaints += browser.complaints()


class Drawing(PageTest):
    """What is on the canvas."""

    def test_a_run_changes_the_picture(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            before = browser.still()
            browser.script("window.stroma.stage.requestDraw()")
            self.assertEqual(difference(browser.still(), before), 0, "a still scene gives another picture")
            for _ in range(10):
                browser.press(Keys.ARROW_RIGHT)
            browser.until("window.stroma.store.shown.header.step >= 10 && window.stroma.frameDrawn === window.stroma.store.shown.header.frame", "ten steps")
            changed = (abs(browser.still().astype(int) - before).max(axis=2) > 8).mean()
            self.assertGreater(changed, 0.002)

    def test_fields_colour_the_bodies(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.click("step")
            browser.until("window.stroma.store.shown.header.step === 1", "a step")
            before, legends = browser.still(), ""
            plain = browser.drawn()[1]
            options = browser.script("Array.from(document.querySelector('[data-test=field]').options, o => o.value)")
            self.assertGreater(len(options), 3)
            for value in options[1:]:
                browser.choose("field", value)
                title = re.sub("([a-z])([A-Z])", r"\1 \2", value.split("|")[0])
                browser.until(f"(e => !e.hidden && e.textContent.startsWith('{title[0].upper() + title[1:]}'))(document.querySelector('[data-test=legend]'))",
                              f"the legend of {value}")
                browser.until(lambda before=before: difference(browser.picture(), before) > 0, f"another picture with {value}")
                before = browser.still()
                legends += browser.find("legend").text + "\n"
            self.assertGreater(browser.drawn()[1], plain / 2)
            for unit in ("Pa", "m/s"):
                self.assertIn(unit, legends)

    def test_a_cut_shows_the_inside(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.click("tab-cut")
            before = browser.still()
            browser.click("cut")
            browser.until("window.stroma.store.view.cut.on && window.stroma.store.bodies[0].tetrahedra", "cells")
            browser.until(lambda: difference(browser.picture(), before) > 0.01, "the cut")
            self.shows_bodies()
            lines = "Math.max(...window.stroma.stage.cut.outlines.material.uniforms.colour.value.toArray())"
            self.assertLess(browser.script(lines), 0.2)
            browser.choose("field", "displacement")
            browser.until(f"{lines} > 0.7", "lines of cells that the dark end of the colours does not swallow")

    def test_the_canvas_says_which_hand_acts_and_how_the_cut_moves(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            hint = "document.querySelector('[data-test=hint]')"
            self.assertTrue(browser.script(f"{hint}.hidden"))
            browser.script("window.stroma.hands.setMode('pull')")
            self.assertIn("Pull: drag a body", browser.script(f"{hint}.textContent"))
            browser.script("window.stroma.store.setCut({ on: true, place: 0.25, normal: [1, 0, 0] })")
            before = browser.script(f"{hint}.textContent")
            self.assertRegex(before, r"Cut at x = [−0-9.]+ [cmµ]?m \(\[ and \] move it")
            self.assertIn(browser.script("document.querySelector('[data-test=cut-at]').textContent"), before)
            browser.script("window.stroma.store.setCut({ place: 0.75 })")
            self.assertNotEqual(browser.script(f"{hint}.textContent"), before)
            browser.script("window.stroma.store.setView({ exaggeration: 10 })")
            self.assertIn("Displacements drawn × 10", browser.script(f"{hint}.textContent"))

    def test_the_legend_names_the_largest_value(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.click("step")
            browser.until("window.stroma.store.shown.header.step === 1", "a step")
            colour = browser.script("Array.from(document.querySelector('[data-test=field]').options, o => o.value)"
                                    ".find(v => v.startsWith('vonMises'))")
            browser.choose("field", colour)
            legend = "document.querySelector('[data-test=legend]')"
            browser.until(f"{legend}.textContent.includes('Maximum')", "the largest value")
            self.assertRegex(browser.find("legend").text, r"(?s)Von Mises \[k?Pa\].*Maximum [0-9.]+ k?Pa.*98 % of the values")

    def test_a_body_that_goes_far_stays_in_sight(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.script("window.stroma.stage.follow(true)")
            far = browser.script("""(() => {
              const { store, stage } = window.stroma;
              const { x } = store.bodies[0];
              for (let i = 0; i < x.length; i += 3) x[i] += 1000 * store.bodies[0].size;
              stage.choose();
              stage.draw();
              const centre = stage.roughBox().getCenter(stage.controls.target.clone());
              return [stage.camera.far / stage.camera.position.distanceTo(centre), centre.distanceTo(stage.controls.target) / store.bodies[0].size];
            })()""")
            self.assertGreater(far[0], 1, "it is not behind the last plane that is drawn")
            self.assertLess(far[1], 1, "the camera has followed")

    def test_one_of_two_distant_bodies_is_framed(self):
        """Bars of 1 m, a kilometre apart: both are dots in one picture, and each fills it alone."""
        bar = ('<Node name="%s"><EulerImplicitSolver/><CGLinearSolver/><RegularGridTopology n="5 2 2" min="%g 0 0" max="%g 0.2 0.2"/>'
               '<MechanicalObject name="dofs"/><UniformMass totalMass="1"/></Node>')
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "two.xml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write('<Node name="root" gravity="0 0 0">' + bar % ("left", 0, 1) + bar % ("right", 1000, 1001) + "</Node>")
            with Server(STROMA, scene, "--paused") as viewed:
                browser.open(viewed.address)
                seen = """(s => s.store.bodies.map((b, i) => { const x = Array.from(b.sceneNode, (_, n) => s.screenOf(i, n).x), eye = s.stage.camera.position.toArray();
                    return [Math.max(...x) - Math.min(...x), Math.hypot(...s.stage.views[i].drawnAt(0).map((p, c) => p - eye[c]))]; }))(window.stroma)"""
                self.assertLess(max(width for width, _ in browser.script(seen)), 5)
                self.assertLess(browser.script("window.stroma.stage.controls.minDistance"), 0.1, "the wheel comes near enough")
                for frame, body in ((lambda: browser.css('[data-test="frame-/right"]').click(), 1), (lambda: browser.press_with(Keys.SHIFT, "F"), 0),
                                    (lambda: browser.press_with(Keys.SHIFT, "F"), 1)):
                    frame()
                    widths, distances = zip(*browser.script(seen))
                    self.assertGreater(widths[body], 200)
                    self.assertLess(max(distances), browser.script("window.stroma.stage.camera.far"), "the other one is behind the last plane that is drawn")
                    browser.still()
                    self.shows_bodies()
                browser.press("f")
                self.assertLess(max(width for width, _ in browser.script(seen)), 5)

    def test_light_and_dark(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            shades = {}
            for scheme in ("light", "dark"):
                browser.scheme(scheme)
                browser.open(viewed.address)
                self.shows_bodies()
                shades[scheme] = numpy.median(browser.still("body"))
            self.assertGreater(shades["light"], shades["dark"] + 60)
            browser.click("theme")
            browser.until(lambda: numpy.median(browser.picture("body")) > shades["dark"] + 60, "the light page")
            browser.script("localStorage.clear()")

    def test_a_small_window_and_a_touch(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.size(400, 700, touch=True)
            browser.open(viewed.address)
            self.shows_bodies()
            wide = browser.script("document.documentElement.scrollWidth")
            self.assertLessEqual(wide, 400, "the page is wider than the window")
            for name in ("run", "pause", "step", "reset"):
                box = browser.find(name).rect
                self.assertTrue(0 <= box["x"] and box["x"] + box["width"] <= 400 and 0 <= box["y"] and box["y"] + box["height"] <= 700, (name, box))
            # a finger turns the view
            before = browser.still()
            browser.pointer("down", 200, 350, touch=True)
            for x in range(200, 290, 15):
                browser.pointer("move", x, 360, touch=True)
            browser.pointer("up", 290, 360, touch=True)
            browser.until(lambda: difference(browser.picture(), before) > 0.01, "the view to turn")
            # and pulls
            browser.script("window.stroma.hands.setMode('pull')")
            self.pull(touch=True)

    def pull(self, touch):
        """By a finger."""
        _, x, y = browser.reachable()
        browser.pointer("down", x, y, touch)
        browser.pointer("move", x + 15, y - 10, touch)
        browser.pointer("move", x + 30, y - 20, touch)
        browser.until("window.stroma.store.newest.header.hands.length > 0", "the hand")
        browser.pointer("up", x + 30, y - 20, touch)
        browser.until("window.stroma.store.newest.header.hands.length === 0", "the hand to let go")


class Reaching(PageTest):
    """Hands and attributes."""

    def test_the_static_answer_is_that_of_the_force_that_is_shown(self):
        """A node is picked at its pixel and pulled; a ConstantForceField of the shown force holds the body there."""
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "block.xml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write(BLOCK.format(""))
            with Server(STROMA, scene, "--paused") as viewed:
                browser.open(viewed.address)
                rest = browser.positions()
                browser.click("tab-hands")
                browser.click("hand-pull")
                browser.choose("grip", "node")
                node, x, y = browser.reachable("r[2]")
                browser.pointer("down", x, y)
                browser.pointer("move", x + 20, y - 30)
                browser.pointer("move", x + 40, y - 60)
                browser.until("window.stroma.store.newest.header.hands.length === 1", "the hand")
                browser.press(Keys.ARROW_RIGHT)
                browser.until("window.stroma.store.shown.header.step === 1 && window.stroma.frameDrawn === window.stroma.store.shown.header.frame", "the step")
                hand, label, pulled = browser.script("(s => { const hand = s.store.shown.header.hands[0]; return [hand,"
                                                     " document.querySelector(`.force[data-hand=\"${hand.hand}\"]`).dataset.force, Array.from(s.positions(0))]; })(window.stroma)")
                label, pulled = float(label), numpy.array(pulled).reshape(-1, 3)
                in_scene = browser.script(f"window.stroma.store.bodies[0].sceneNode[{hand['node']}]")
                browser.pointer("up", x + 40, y - 60)
                self.assertEqual(hand["node"], node)
                self.assertAlmostEqual(label, float(numpy.linalg.norm(hand["force"])), places=12)
                delays = browser.script("window.stroma.delays.length")
                self.assertGreater(delays, 0, "no delay from the pointer to the picture was measured")
            moved = abs(pulled - rest).max()
            self.assertGreater(moved, 1e-3)
            force = " ".join(repr(float(value)) for value in hand["force"])
            with open(scene, "w", encoding="utf-8") as file:
                file.write(BLOCK.format(f'<ConstantForceField indices="{in_scene}" totalForce="{force}"/>'))
            with Server(STROMA, scene, "--paused") as viewed:
                page = viewed.page()
                page.do("step", count=1)
                page.picture(1)
                # the picture has single precision; test_protocol.py compares in double
                self.assertLess(abs(page.positions() - pulled).max(), 1e-6 * moved + 0.35 * 2**-23)

    def test_hold_and_push(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            _, x, y = browser.reachable()
            browser.press("3")
            browser.pointer("down", x, y)
            browser.pointer("move", x + 10, y)
            browser.pointer("up", x + 10, y)
            browser.press(Keys.ARROW_RIGHT)
            browser.until("(h => h.length === 1 && h[0].kind === 'hold')(window.stroma.store.newest.header.hands)", "what stays held")
            browser.press("4")
            browser.until("window.stroma.store.shown.header.step === 1 && window.stroma.frameDrawn === window.stroma.store.shown.header.frame", "the step")
            _, x, y = browser.reachable()
            browser.pointer("down", x, y)
            browser.pointer("move", x + 2, y)
            browser.press(Keys.ARROW_RIGHT)
            browser.until("window.stroma.store.newest.header.hands.some(h => h.kind === 'push')", "the ball")
            browser.press(Keys.ESCAPE)
            browser.until("window.stroma.store.newest.header.hands.every(h => h.kind === 'hold')", "the ball to be gone")
            browser.pointer("up", x + 2, y)
            browser.click("tab-hands")
            browser.click("release-all")
            browser.until("window.stroma.store.newest.header.hands.length === 0", "all to be let go")

    def test_a_frame_is_turned_by_the_end_of_its_axis(self):
        """x of a free frame, seen from the front, is dragged up: it turns about z and stays where it is."""
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "frame.xml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write('<Node name="root" dt="0.02" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject '
                           'template="Rigid3" position="0 0 0 0 0 0 1  4 0 0 0 0 0 1"/><UniformMass totalMass="2" inertia="1 1 1"/></Node>')
            with Server(STROMA, scene, "--paused") as viewed:
                browser.open(viewed.address)
                browser.press("2")
                tip = "(s => s.stage.toScreen(s.stage.views[0].axesOf(1)[{}]))(window.stroma)"
                x, up = browser.script(tip.format(0)), browser.script(tip.format(1))
                browser.pointer("down", round(x["x"]), round(x["y"]))
                browser.pointer("move", round(up["x"]), round(up["y"]))
                browser.until("window.stroma.store.newest.header.hands.some(h => h.turns)", "the hand")
                browser.press(*[Keys.ARROW_RIGHT] * 40)
                browser.drawn_step(40)
                torque = browser.script("window.stroma.store.shown.header.hands[0].force")
                turn = browser.script("Array.from(window.stroma.store.bodies[0].turn)")
                places = browser.positions()
                browser.pointer("up", round(up["x"]), round(up["y"]))
        self.assertGreater(2 * numpy.arctan2(turn[6], turn[7]), 0.5, f"turned about z; torque {torque}")
        numpy.testing.assert_allclose(turn[:4], [0, 0, 0, 1], atol=1e-7)
        numpy.testing.assert_allclose(places, [[0, 0, 0], [4, 0, 0]], atol=1e-6)

    def type_over(self, field, text):
        """As a person does: new values from the server leave alone what has the focus."""
        browser.script("(e => { e.focus(); e.select(); })(document.querySelector(arguments[0]))", field)
        browser.press(text, Keys.ENTER)

    def test_an_attribute_is_edited_and_a_bad_value_refused(self):
        scene = example("organ.xml")
        with Server(STROMA, scene, "--paused") as viewed:
            browser.open(viewed.address)
            browser.until("document.querySelector('button[data-path=\"/organ/fem\"]')", "the tree")
            browser.css('button[data-path="/organ/fem"]').click()
            field = '[data-path="/organ/fem"][data-attribute="youngModulus"]:not(button)'
            self.type_over(field, "-3")
            error = '[data-error="/organ/fem.youngModulus"]'
            browser.until(lambda: browser.css(error).is_displayed() and browser.css(error).text, "the refusal")
            self.assertIn("expected", browser.css(error).text)
            self.assertEqual(browser.css(field).get_attribute("value"), "-3")
            self.type_over(field, "20000")
            browser.until(lambda: not browser.css(error).is_displayed(), "the edit")
            for _ in range(5):
                browser.click("step")
            browser.until("window.stroma.store.shown.header.step === 5", "five steps")
            state = viewed.page().hash()[1]
            self.assertEqual(state, hash_of_run(scene, 5, "--set", "/organ/fem.youngModulus=20000"))
            browser.click("tab-export")
            _, xml = browser.download(lambda: browser.click("export-xml"), ".xml")
            with open(scene, "rb") as file:
                self.assertEqual(xml, file.read().replace(b'youngModulus="10000"', b'youngModulus="20000"'))
            path, actions = browser.download(lambda: browser.click("export-actions"), ".actions")
            self.assertGreaterEqual(len(actions.splitlines()), 2)
            self.assertEqual(hash_of_run(scene, 5, "--replay", path), state)

    def test_keys(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.press(" ")
            browser.until(f"{WATCHED}.running", "the run")
            browser.press(" ")
            browser.until(f"!{WATCHED}.running", "the pause")
            step = viewed.page().hash()[0]
            browser.press(Keys.ARROW_RIGHT)
            browser.until(f"window.stroma.store.shown.header.step === {step + 1}", "one step")
            for key, value in (("w", "view.wireframe"), ("c", "view.cut.on"), ("l", "view.legend")):
                before = browser.script(f"window.stroma.store.{value}")
                browser.press(key)
                browser.until(f"window.stroma.store.{value} === {str(not before).lower()}", key)
            for key, mode in (("2", "pull"), ("3", "hold"), ("4", "push"), ("1", "look")):
                browser.press(key)
                self.assertEqual(browser.script("window.stroma.hands.mode"), mode)
            browser.press("?")
            browser.until(lambda: browser.find("keys").is_displayed(), "the list of keys")
            browser.press(Keys.ESCAPE)
            browser.until(lambda: not browser.find("keys").is_displayed(), "the list to close")
            browser.press("f")
            browser.press_with(Keys.SHIFT, "R")
            browser.until("window.stroma.store.shown.header.step === 0", "the reset")

    def test_caps_lock_does_not_reset(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.press(Keys.ARROW_RIGHT)
            browser.drawn_step(1)
            browser.key("R")  # Caps Lock
            browser.press(Keys.ARROW_RIGHT)
            browser.drawn_step(2)
            browser.key("r", shiftKey=True)  # and Shift with it
            browser.until("window.stroma.store.shown.header.step === 0", "the reset")

    def test_the_view_and_hands_by_keys(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            place = "[...window.stroma.stage.camera.position.toArray(), ...window.stroma.stage.controls.target.toArray()]"
            for keys in ((Keys.SHIFT, Keys.ARROW_LEFT), (Keys.SHIFT, Keys.ARROW_UP), (Keys.ALT, Keys.ARROW_LEFT), (Keys.ALT, Keys.ARROW_DOWN)):
                before = numpy.array(browser.script(place))
                browser.press_with(*keys)
                after = numpy.array(browser.script(place))
                moves = keys[0] == Keys.ALT
                self.assertGreater(abs(after - before)[:3].max(), 1e-4, keys)
                self.assertEqual(abs(after - before)[3:].max() > 1e-6, moves, keys)
                self.assertAlmostEqual(numpy.linalg.norm((after[:3] - after[3:])), numpy.linalg.norm(before[:3] - before[3:]), places=6)
            self.assertIn("/", browser.driver.current_url)
            distance = "window.stroma.stage.camera.position.distanceTo(window.stroma.stage.controls.target)"
            before = browser.script(distance)
            browser.press("+")
            self.assertAlmostEqual(browser.script(distance), 0.9 * before, places=9)
            browser.press("-")
            self.assertAlmostEqual(browser.script(distance), before, places=9)
            browser.press("r")
            browser.press("3", "n")
            browser.until(lambda: browser.find("picked").is_displayed(), "the picked node")
            browser.press(Keys.ENTER)
            browser.until("window.stroma.store.newest.header.hands.length === 1", "the hand")
            start = numpy.array(browser.script("window.stroma.store.newest.header.hands[0].to"))
            browser.press(Keys.ARROW_UP, Keys.ARROW_UP, Keys.ARROW_RIGHT, Keys.PAGE_UP)
            right, up, away = (numpy.array(browser.script(f"window.stroma.stage.inPicture({axis}).toArray()")) for axis in ("1, 0, 0", "0, 1, 0", "0, 0, 1"))
            wanted = 0.02 * browser.script("window.stroma.store.bodies[0].size") * (2 * up + right + away)
            browser.until(lambda: abs(numpy.array(browser.script("window.stroma.store.newest.header.hands[0].to")) - start - wanted).max() < 1e-6, "the moves")
            self.assertEqual(browser.script("window.stroma.store.newest.header.step"), 0, "an arrow made a step")
            browser.press(Keys.ENTER)
            browser.press(Keys.ARROW_RIGHT)
            browser.drawn_step(1)
            self.assertEqual(browser.script("window.stroma.store.newest.header.hands.map(h => h.kind)"), ["hold"])
            browser.press(Keys.ENTER, Keys.ESCAPE)  # takes it again, and lets go
            browser.until("window.stroma.store.newest.header.hands.length === 0", "the hand to let go")

    def test_push_and_arrows_where_the_body_is_exaggerated(self):
        """The ball touches the true body in truth and the drawn body in the picture; arrows begin at the mean of the nodes."""
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            for _ in range(15):
                browser.press(Keys.ARROW_RIGHT)
            browser.drawn_step(15)
            browser.script("window.stroma.store.setView({exaggeration: 4})")
            browser.script("window.stroma.stage.fit()")
            browser.press("4")
            # of what sank most
            node, x, y = browser.reachable("(d => d)(Math.hypot(...[0, 1, 2].map(c => b.x[3 * n + c] - b.rest[3 * n + c])))")
            of = "Array.from(window.stroma.store.bodies[0].{}.subarray(" + f"{3 * node}, {3 * node + 3}))"
            rest, true = (numpy.array(browser.script(of.format(name))) for name in ("rest", "x"))
            browser.pointer("down", x, y)
            browser.until("window.stroma.store.shown.header.hands.length === 1", "the ball")
            ball = "[window.stroma.store.shown.header.hands[0], Array.from(window.stroma.hands.balls.origin.array.slice(0, 4))]"
            hand, drawn = browser.script(ball)
            radius = hand["radius"]
            pixel = 0.02 * radius + 3e-3 * browser.script("window.stroma.store.bodies[0].size")
            self.assertGreater(3 * numpy.linalg.norm(true - rest), 3 * pixel, "too small a deformation to tell")
            self.assertAlmostEqual(numpy.linalg.norm(numpy.array(hand["centre"]) - true), radius, delta=pixel)
            self.assertAlmostEqual(numpy.linalg.norm(numpy.array(drawn[:3]) - (rest + 4 * (true - rest))), radius, delta=pixel)
            browser.pointer("move", x + 40, y)
            browser.until(f"Math.abs({ball}[0].centre[0] - {hand['centre'][0]!r}) > 1e-9", "the move")
            moved = numpy.linalg.norm(numpy.array(browser.script(ball)[0]["centre"]) - hand["centre"])
            seen = numpy.array(browser.script("((s, p) => { s.camera.updateMatrixWorld(); const h = 2 * Math.tan(s.camera.fov * Math.PI / 360) / s.canvas.clientHeight;"
                                              " const v = s.inPicture(0, 0, 1).toArray(); return 40 * h * v.reduce((d, c, i) => d + c * (p[i] - s.camera.position.toArray()[i]), 0); })"
                                              "(window.stroma.stage, arguments[0])", drawn[:3]))
            self.assertAlmostEqual(moved, float(seen) / 4, delta=0.05 * moved)
            browser.press(Keys.ESCAPE)
            browser.pointer("up", x + 40, y)
            browser.until("window.stroma.store.newest.header.hands.length === 0 && window.stroma.store.shown === window.stroma.store.newest", "the ball to be gone")
            # another page's hand, as a frame tells it
            other = {"hand": "h1", "client": 99, "kind": "pull", "body": 0, "node": node, "at": [0.1, 0.2, 0.3], "rest_at": [0.1, 0.1, 0.1], "to": [0.2, 0.2, 0.2], "force": [1, 0, 0]}
            browser.script("window.stroma.store.show({...window.stroma.store.shown, header: {...window.stroma.store.shown.header, hands: [arguments[0]]}})", other)
            arrow = browser.script("[...window.stroma.hands.arrows.origin.array.slice(0, 3), ...window.stroma.hands.arrows.along.array.slice(0, 3)]")
            self.assertLess(abs(numpy.array(arrow) - [0.1, 0.5, 0.9, 0.4, 0.0, -0.4]).max(), 1e-6)

    def test_attributes_change_in_place_and_keep_what_is_typed(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.until("document.querySelector('button[data-path=\"/organ/fem\"]')", "the tree")
            browser.css('button[data-path="/organ/fem"]').click()
            young, poisson = (browser.css(f'[data-path="/organ/fem"][data-attribute="{name}"]:not(button)') for name in ("youngModulus", "poissonRatio"))
            link = browser.css('button[data-path="/organ/fem"]')
            young.click()
            young.send_keys("5")
            typed = young.get_attribute("value")
            other = viewed.page()
            before = browser.script("(window.stroma.store.on('components', () => (window.told = (window.told ?? 0) + 1)), window.told ?? 0)")
            browser.script("window.stroma.commands.takeControl()")
            browser.until(f"{WATCHED}.control === window.stroma.store.scene.client", "control")
            browser.script("window.stroma.commands.ask({do: 'set', path: '/organ/fem', attribute: 'poissonRatio', value: '0.31'})")
            browser.script("window.stroma.commands.request({do: 'components'})")
            browser.until(f"window.told > {before}", "the components")
            browser.until(lambda: poisson.get_attribute("value") == "0.31", "the new value in the old field")
            self.assertEqual(young.get_attribute("value"), typed, "what is typed is lost")
            self.assertTrue(browser.script("document.activeElement === arguments[0]", young), "the focus is lost")
            link.click()  # would be stale
            del other

    def test_what_a_monitor_watches_is_plotted(self):
        with Server(STROMA, example("ten_tetrahedra.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            browser.until("document.querySelector('button[data-path=\"/block/mirror\"]')", "the tree")
            browser.css('button[data-path="/block/mirror"]').click()
            browser.click("plot-monitor")
            watched = browser.script("window.stroma.store.watched.map(({body, node}) => [window.stroma.store.bodies[body].node, window.stroma.store.bodies[body].sceneNode[node]])")
            self.assertEqual(watched, [["/block", 6], ["/block", 90]])
            browser.click("step")
            browser.until("document.querySelectorAll('.plot[data-plot^=\"node.\"]').length >= 4", "their plots")

    def test_controls_have_names(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            browser.open(viewed.address)
            nameless = browser.script("Array.from(document.querySelectorAll('button, input, select, [role=tab]')).filter(e => !(e.textContent.trim()"
                                      " || e.getAttribute('aria-label') || e.title || (e.labels && e.labels.length))).map(e => e.outerHTML)")
            self.assertEqual(nameless, [])


class Connections(PageTest):
    """Loss and return; two pages; recordings."""

    def test_the_connection_is_lost_and_comes_back(self):
        self.quiet = False  # the browser complains of the connection, rightly
        with Server(STROMA, example("organ.xml")) as viewed:
            proxy = Proxy(viewed.port)  # a server that is started again has another token
            browser.open(viewed.address.replace(f":{viewed.port}/", f":{proxy.port}/"))
            browser.until(f"{WATCHED}.step > 2", "steps")
            proxy.cut()
            browser.until(lambda: browser.find("banner").is_displayed() and "lost" in browser.find("banner").text, "the word on the loss")
            step = browser.script(f"{WATCHED}.step")
            self.shows_bodies()
            proxy.mend()
            browser.until(lambda: not browser.find("banner").is_displayed(), "the connection to come back")
            browser.until(f"{WATCHED}.step > {step} && window.stroma.store.shown.header.step > {step}", "the run, which went on")
            browser.click("pause")
            browser.until(f"!{WATCHED}.running && window.stroma.store.shown.header.step === {WATCHED}.step", "the pause")
            # a server that is stopped says nothing; what it missed comes when it goes on
            step = browser.script(f"{WATCHED}.step")
            viewed.process.send_signal(signal.SIGSTOP)
            browser.click("step")
            viewed.process.send_signal(signal.SIGCONT)
            browser.until(f"window.stroma.store.shown.header.step === {step + 1}", "the step")
            browser.leave()
            proxy.close()

    def test_two_pages(self):
        with Server(STROMA, example("organ.xml"), "--paused") as viewed:
            other = viewed.page()
            other.do("control")
            browser.open(viewed.address)
            browser.click("run")
            browser.until(lambda: browser.find("banner").is_displayed() and "control" in browser.find("banner").text, "the word on control")
            other.do("step", count=2)
            browser.until("window.stroma.store.shown.header.step === 2", "the other page's steps")
            browser.click("take-control")
            browser.until(f"{WATCHED}.control === window.stroma.store.scene.client", "control")
            browser.until(lambda: not browser.find("banner").is_displayed(), "the banner to go")
            browser.click("step")
            other.picture(3)
            self.assertIn("control", other.refused("run"))

    def test_a_recording_is_scrubbed(self):
        with tempfile.TemporaryDirectory() as folder:
            recorded = os.path.join(folder, "run")
            command("run", example("organ.xml"), "-n", "20", "-q", "--record", recorded, "--record-every", "4")
            with Server(STROMA, recorded) as viewed:
                browser.open(viewed.address)
                self.assertFalse(browser.find("run").is_displayed())
                before = browser.still()
                for index in (5, 2, 0):  # it opens with the first instant
                    browser.script("(e => { e.value = arguments[1]; e.dispatchEvent(new Event('input', {bubbles: true})); })(arguments[0])",
                                   browser.find("timeline"), str(index))
                    browser.until(f"window.stroma.store.shown.header.index === {index} && window.stroma.frameDrawn === window.stroma.store.shown.header.frame",
                                  f"instant {index}")
                    browser.until(lambda before=before: difference(browser.picture(), before) > 0, f"another picture of instant {index}")
                    before = browser.still()
                browser.click("play")
                browser.until("window.stroma.store.shown.header.index >= 3", "the recording to play")

    def test_a_scene_sent_again_keeps_choices_and_hands(self):
        """As when springs are set in a run. Until the server tells of it, its frames are of another generation: each is answered."""
        with Server(STROMA, example("organ.xml")) as viewed:
            browser.open(viewed.address)
            browser.until(f"{WATCHED}.running", "the run")
            browser.press(" ")
            browser.until(f"!{WATCHED}.running && window.stroma.store.shown.header.step === {WATCHED}.step", "the pause")
            browser.press("3", "n", Keys.ENTER, Keys.ARROW_UP, Keys.ENTER)
            browser.until("window.stroma.store.newest.header.hands.length === 1 && window.stroma.store.newest === window.stroma.store.shown", "what is held")
            browser.script("window.stroma.store.setView({exaggeration: 2, wireframe: true})")
            browser.script("window.stroma.stage.turn(0.3, 0.2)")
            browser.script("window.stroma.panels.tabs.get('plots').panel.watch(0, 3)")
            state = ("(s => [s.hands.kept.size, s.store.watched.length, s.store.view.exaggeration, s.store.view.wireframe, s.history.frames.length > 0,"
                     " s.stage.camera.position.toArray(), s.store.bodies[0].held.length, s.frameDrawn >= 0])(window.stroma)")
            before = browser.script(state)
            self.assertEqual(before[0], 1)
            browser.script("""(s => { const arrays = {};
                for (const b of s.store.bodies) for (const [name, key] of [['node', 'sceneNode'], ['rest', 'rest'], ['triangles', 'triangles'], ['owner', 'owner'],
                  ['edges', 'edges'], ['points', 'points'], ['springs', 'springs']]) arrays[`${b.index}.${name}`] = b[key].slice();
                s.store.receivePacket({header: {...s.store.scene, generation: s.store.scene.generation + 1}, arrays, bytes: 0}); })(window.stroma)""")
            self.assertEqual(browser.script(state), before)
            self.shows_bodies()
            browser.script("(s => { window.sent = []; const send = s.connection.send.bind(s.connection);"
                           " s.connection.send = m => { window.sent.push(m); return send(m); }; })(window.stroma)")
            browser.press(" ")
            browser.until("window.sent.filter(m => m.do === 'drawn').length > 5", "the answers to frames that are not drawn")

    def test_looking_back_while_the_run_goes_on(self):
        with Server(STROMA, example("organ.xml")) as viewed:
            browser.open(viewed.address)
            browser.until("window.stroma.history.frames.length > 20", "frames")
            browser.script("(e => { e.value = 3; e.dispatchEvent(new Event('input', {bubbles: true})); })(arguments[0])", browser.find("timeline"))
            step = browser.script("window.stroma.store.shown.header.step")
            browser.until(f"{WATCHED}.step > {step}", "a step that is not shown")
            now = browser.script(f"{WATCHED}.step")
            browser.until(f"{WATCHED}.step > {now + 5}", "the run to go on")
            self.assertEqual(browser.script("window.stroma.store.shown.header.step"), step)
            browser.click("live")
            browser.until(f"window.stroma.store.shown.header.step > {now}", "the present")


class Exports(PageTest):
    """Files that the page writes."""

    def test_picture_video_page_and_numbers(self):
        with Server(STROMA, example("organ.xml")) as viewed:
            browser.open(viewed.address)
            browser.until("window.stroma.history.frames.length > 10", "frames")
            browser.click("tab-export")
            _, png = browser.download(lambda: browser.click("export-png"), ".png")
            image = numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
            self.assertGreater(len(numpy.unique(image.reshape(-1, 3), axis=0)), 8)
            browser.click("export-video")
            browser.script("(r => { window.recorded = 0; r.addEventListener('dataavailable', e => { window.recorded += e.data.size; }); })"
                           "(window.stroma.panels.tabs.get('export').panel.recorder)")
            browser.until("window.recorded > 5000", "some pictures to be coded")
            _, video = browser.download(lambda: browser.click("export-video"), ".webm")
            self.assertEqual(video[:4], b"\x1a\x45\xdf\xa3")
            self.assertGreater(len(video), 5000)
            browser.click("pause")
            # the last picture comes after the word on the pause
            browser.until(f"!{WATCHED}.running && window.stroma.store.newest.header.step === {WATCHED}.step && "
                          "window.stroma.frameDrawn === window.stroma.store.newest.header.frame", "the picture of the pause")
            frames, count = None, "window.stroma.history.frames.length"
            while frames != browser.script(count):  # of a picture that came meanwhile nobody knows whether the file has it
                frames, last = browser.script(count), browser.positions()
                path, html = browser.download(lambda: browser.click("export-html"), ".html")
        self.assertNotIn(viewed.token.encode(), html)
        browser.open("file://" + path)
        self.shows_bodies()
        self.assertEqual(browser.script("window.stroma.timeline.count"), frames)
        browser.script("window.stroma.timeline.stop(), window.stroma.timeline.seek(arguments[0])", frames - 1)  # it plays by itself
        browser.until("window.stroma.frameDrawn === window.stroma.store.shown.header.frame", "the last picture")
        extent = numpy.ptp(last, axis=0).max()
        self.assertLess(abs(browser.positions() - last).max(), extent / 65535)
        self.assertFalse(browser.find("run").is_displayed())

    def test_the_command_writes_a_page_too(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "organ.html")
            command("view", example("organ.xml"), "--export", file, "-n", "20", "--every", "4", "--field", "vonMises", "--inside")
            browser.open("file://" + file)
            self.shows_bodies()
            self.assertEqual(browser.script("window.stroma.timeline.count"), 6)
            before = browser.still()
            browser.script("window.stroma.timeline.seek(5)")
            browser.until(lambda: difference(browser.picture(), before) > 0, "another instant")
            self.assertEqual(browser.script("performance.getEntriesByType('resource').filter(e => !e.name.startsWith('data:') && !e.name.startsWith('blob:')).length"), 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
