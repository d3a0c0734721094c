#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma picture` draws what it says, without a display. Pictures are read back with PIL, colours compared with matplotlib's.
Usage: test_picture.py TREE STROMA [SUITE...]"""
import glob
import os
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])
MARGIN = 1.12  # around what is drawn
LONGEST = 900  # seconds of a command, after which it hangs
EXAMPLES = sorted(glob.glob(os.path.join(TREE, "scenes", "examples", "*.xml")))
WITHOUT_DISPLAY = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}

# A cube of 1 m from the origin. What moves it moves its upper face by 0.5 m along z, within a step.
CUBE = """<Node name="root" units="m kg s" dt="0.01" gravity="0 0 0"><Node name="cube"><EulerImplicitSolver/><CGLinearSolver/>
  <RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>
  <UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>%s</Node></Node>"""
MOVED = """<BoxROI name="below" box="-1 -1 -1 2 0.1 2"/><BoxROI name="amid" box="-1 0.4 -1 2 0.6 2"/>
  <BoxROI name="above" box="-1 0.9 -1 2 2 2"/><FixedProjectiveConstraint indices="@below.indices"/>
  <LinearMovementProjectiveConstraint indices="@amid.indices" keyTimes="0 0.01 1" movements="0 0 0  0 0 0.25  0 0 0.25"/>
  <LinearMovementProjectiveConstraint indices="@above.indices" keyTimes="0 0.01 1" movements="0 0 0  0 0 0.5  0 0 0.5"/>"""
FALLING = '<ConstantForceField indices="0" totalForce="0 -9.81 0"/>'

EXPLODING = ('<Node name="root" dt="0.1"><EulerExplicitSolver/><Node name="cube">'
             + (CUBE % FALLING).split("<CGLinearSolver/>")[1].replace('youngModulus="1000"', 'youngModulus="1e9"'))


def run(*arguments, folder, code=0):
    result = subprocess.run([STROMA, *map(str, arguments)], capture_output=True, text=True, cwd=folder, env=WITHOUT_DISPLAY,
                            timeout=LONGEST)
    assert result.returncode == code, f"{arguments} ended with {result.returncode}\n{result.stdout}{result.stderr}"
    return result.stdout + result.stderr


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGBA")).astype(int)


def body(image):
    """Which pixels are neither white nor clear."""
    return (image[:, :, 3] > 0) & (image[:, :, :3].min(axis=2) < 250)


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="picture")
        self.addCleanup(subprocess.run, ["rm", "-rf", self.folder])

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return name

    def picture(self, *arguments, code=0):
        return run("picture", *arguments, folder=self.folder, code=code)


FRAMES = """<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>%s<MechanicalObject template="Rigid3"
  position="0 0 0 0 0 0 1  1 0 0 0 0 0.70710678 0.70710678"/><UniformMass totalMass="1"/>%s</Node>"""


class EveryExample(Case):
    def test_is_drawn_and_opens_no_display(self):
        for scene in EXAMPLES:
            name = os.path.splitext(os.path.basename(scene))[0]
            with self.subTest(name):
                said = self.picture(scene, "-n", 2, "--size", "320x240", "--quiet")
                self.assertIn(f"{name}.png: ", said)
                image = pixels(self.path(f"{name}.png"))
                self.assertEqual(image.shape, (240, 320, 4))
                seen = body(image[:, :230])  # left of the legend
                self.assertGreater(seen.mean(), 0.02, "the body is not seen")
                self.assertLess(seen.mean(), 0.9)
                self.assertTrue((image[0, :, :3] == 255).all(), "the border is white")
                self.assertTrue((image[:, :, 3] == 255).all())

    def test_opens_the_renderer_for_pictures_only(self):
        def libraries(*arguments):
            environment = {**WITHOUT_DISPLAY, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": self.path("opened")}
            subprocess.run([STROMA, *arguments], cwd=self.folder, env=environment, capture_output=True, check=True)
            text = ""
            for file in glob.glob(self.path("opened.*")):
                with open(file, encoding="utf-8", errors="replace") as opened:
                    text += opened.read()
                os.remove(file)
            return text
        scene = self.write("cube.xml", CUBE % "")
        drawn = libraries("picture", scene, "-n", "1")
        self.assertIn("libvtkRenderingOpenGL2", drawn)
        self.assertIn("libEGL", drawn)
        ran = libraries("run", scene, "-n", "1")
        self.assertIn("libc.so", ran)
        for library in ("libvtk", "libEGL", "libGLEW", "libX11", "picture.so"):
            self.assertNotIn(library, ran)


class Pixels(Case):
    def test_frames_are_drawn_whole_with_axes_that_turn(self):
        self.write("frames.xml", FRAMES % ("", ""))
        self.picture("frames.xml", "-n", 0, "--view", "front", "--size", "400x300", "--no-legend", "--quiet")
        image = pixels(self.path("frames.png"))
        red = (image[:, :, 0] > 150) & (image[:, :, 1] < 130) & (image[:, :, 2] < 130)
        green = (image[:, :, 1] > 110) & (image[:, :, 0] < 110) & (image[:, :, 2] < 110)
        for colour in (red, green):
            self.assertGreater(colour.sum(), 50)
        seen = body(image[:, :])
        rows, columns = np.nonzero(seen.any(axis=1))[0], np.nonzero(seen.any(axis=0))[0]
        self.assertGreater(rows[0], 2, "cut off at the top")
        self.assertLess(columns[-1], image.shape[1] - 3, "cut off at the right")
        # x of the first points right, that of the second, which is turned by a quarter, up; y of the second left
        middle = (columns[0] + columns[-1]) // 2
        above = red[:220]  # the axes of the picture are in its lower corner
        right = np.nonzero(above[:, middle:].any(axis=1))[0]
        left = np.nonzero(above[:, :middle].any(axis=1))[0]
        self.assertGreater(right[-1] - right[0], 3 * (left[-1] - left[0]))

    def test_beams_are_tubes_that_bend(self):
        scene = FRAMES % ('<MeshTopology edges="0 1"/>', '<BeamFEMForceField radius="0.1"/><ConstantForceField indices="1" '
                          'forces="0 0 0  0 0 1"/><FixedProjectiveConstraint indices="0"/>')
        self.write("beam.xml", scene.replace("0.70710678 0.70710678", "0 1"))
        self.picture("beam.xml", "-n", 0, "--view", "front", "--size", "400x300", "--bare", "--field", "none", "--quiet")
        seen = body(pixels(self.path("beam.png")))
        rows, columns = np.nonzero(seen.any(axis=1))[0], np.nonzero(seen.any(axis=0))[0]
        self.assertAlmostEqual((rows[-1] - rows[0]) / (columns[-1] - columns[0]), 0.2, delta=0.02)

    LOOK = ("--view", "front", "--bare", "--no-shading", "--size", "400x400")

    def test_a_cube_covers_what_it_should(self):
        scene = self.write("cube.xml", CUBE % "")
        self.picture(scene, "-n", 0, "--field", "none", *self.LOOK)
        seen = body(pixels(self.path("cube.png")))
        self.assertAlmostEqual(seen.sum() / (400 / MARGIN) ** 2, 1, delta=0.01)
        rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        for line in (rows, columns):
            self.assertAlmostEqual(line[0], 400 * (1 - 1 / MARGIN) / 2, delta=1.5)
            self.assertAlmostEqual(line[-1], 399 - 400 * (1 - 1 / MARGIN) / 2, delta=1.5)
        self.assertTrue((pixels(self.path("cube.png"))[200, 200, :3] == (0xc9, 0x82, 0x76)).all())

    def test_colours_are_those_of_the_map(self):
        import matplotlib
        scene = self.write("cube.xml", CUBE % MOVED)
        for name in ("viridis", "cividis", "inferno"):
            self.picture(scene, "-n", 1, "--field", "displacement", "--range", "0,1", "--colours", name, *self.LOOK)
            image = pixels(self.path("cube.png"))
            side = 400 / MARGIN
            for height in (0.02, 0.25, 0.5, 0.75, 0.98):
                row = int(200 + (0.5 - height) * side)
                expected = 255 * np.array(matplotlib.colormaps[name](0.5 * height)[:3])
                difference = np.abs(image[row, 100:300, :3] - expected).max()
                self.assertLess(difference, 6, f"{name} at {height}")

    def test_the_legend_has_the_colours_of_the_map(self):
        import matplotlib
        scene = self.write("cube.xml", CUBE % MOVED)
        self.picture(scene, "-n", 1, "--field", "displacement", "--range", "0,1", "--size", "600x450")
        image = pixels(self.path("cube.png"))[:, :, :3]
        for t in (0.1, 0.5, 0.9):
            expected = 255 * np.array(matplotlib.colormaps["viridis"](t)[:3])
            right = image[:, 480:]  # the body has colours up to 0.5
            self.assertLess(np.abs(right - expected).max(axis=2).min(), 8, t)
        self.picture(scene, "-n", 1, "--field", "displacement", "--range", "0,1", "--size", "600x450", "--no-legend")
        image = pixels(self.path("cube.png"))[:, :, :3]
        self.assertGreater(np.abs(image - 255 * np.array(matplotlib.colormaps["viridis"](0.9)[:3])).max(axis=2).min(), 20)

    def test_views_stand_side_by_side(self):
        """A cube with its upper face moved along z: a square from the front, sheared from the side."""
        scene = self.write("cube.xml", CUBE % MOVED)
        self.picture(scene, "-n", 1, "--views", "front,side", "--bare", "--size", "800x400")
        image = pixels(self.path("cube.png"))
        front, side = body(image[:, :400]), body(image[:, 400:])
        scale = 400 / MARGIN / 1.5  # the wider of the two gives the scale of both
        self.assertAlmostEqual(front.sum() / scale**2, 1, delta=0.02)
        self.assertAlmostEqual(side.sum() / scale**2, 1, delta=0.02)
        widths = [np.ptp(np.flatnonzero(half.any(axis=0))) + 1 for half in (front, side)]
        self.assertAlmostEqual(widths[0] / scale, 1, delta=0.02)
        self.assertAlmostEqual(widths[1] / scale, 1.5, delta=0.02)
        top, bottom = (np.flatnonzero(side[row]).mean() for row in (int(200 - 0.48 * scale), int(200 + 0.48 * scale)))
        self.assertLess(top, bottom, "z is to the left of who looks from the right")

    def test_up_is_against_gravity_however_small_its_number_is(self):
        """A plate that is thin along y: along z one looks at it from above where gravity goes along z, else at its edge."""
        plate = (CUBE % "").replace('max="1 1 1"', 'max="1 0.25 1"')
        for gravity, height in (("0 0 -9.81", 0.25), ("0 0 -1e-15", 0.25), ("0 0 0", 1), ("0 -1e-15 0", 1)):
            scene = self.write("cube.xml", plate.replace('gravity="0 0 0"', f'gravity="{gravity}"'))
            self.picture(scene, "-n", 0, "--view", "top", "--bare", "--size", "400x400")
            seen = body(pixels(self.path("cube.png")))
            high, wide = (np.ptp(np.flatnonzero(seen.any(axis=axis))) + 1 for axis in (1, 0))
            self.assertAlmostEqual(high / wide, height, delta=0.02, msg=gravity)

    def test_a_cut_halves_the_cube(self):
        scene = self.write("cube.xml", CUBE % "")
        for cut, part in (("x=0.25", 0.25), ("x=0.25,below", 0.25), ("x=0.25,above", 0.75), ("z=0.5", 1)):
            self.picture(scene, "-n", 0, "--cut", cut, "--field", "displacement", *self.LOOK)
            seen = body(pixels(self.path("cube.png")))
            self.assertAlmostEqual(seen.sum() / (400 / MARGIN) ** 2, part, delta=0.01, msg=cut)

    def test_shapes_are_exaggerated_and_numbers_are_not(self):
        scene = self.write("cube.xml", CUBE % MOVED)
        self.picture(scene, "-n", 1, "--view", "side", "--bare", "--size", "400x400", "--exaggerate", 4, "--field",
                     "displacement", "--range", "0,1")
        seen = body(pixels(self.path("cube.png")))
        width, height = (np.ptp(np.flatnonzero(seen.any(axis=axis))) + 1 for axis in (0, 1))
        self.assertAlmostEqual(width / height, 3, delta=0.05)

    def test_exaggeration_leaves_colours_and_range(self):
        scene = self.write("cube.xml", CUBE % MOVED)
        look = ("-n", 1, "--view", "front", "--size", "400x400", "--field", "displacement", "--no-shading")
        ranges, images = set(), []
        for number, more in enumerate(((), ("--exaggerate", 1), ("--exaggerate", 0), ("--exaggerate", 2))):
            said = self.picture(scene, *look, "-o", f"{number}.png", *more)
            ranges.add(said.split(": ")[1].split(",")[0])
            images.append(pixels(self.path(f"{number}.png")))
            with Image.open(self.path(f"{number}.png")) as image:
                factor = more[1] if more else 1
                self.assertEqual(f"displacements drawn × {factor}" in image.text["Description"], factor != 1)
        captions = [(image[375:, :340, :3].min(axis=2) < 128).sum() for image in images]
        self.assertGreater(min(captions[2], captions[3]), 1.5 * captions[0], "the picture says that it is exaggerated")
        self.assertEqual(ranges, {"displacement 0 to 500 mm"})
        self.assertTrue((images[0] == images[1]).all())
        # the face moves along the view: a factor changes neither what is seen of it nor the legend
        self.assertTrue((images[0][:, 340:] == images[3][:, 340:]).all())
        self.assertLess(np.abs(images[0] - images[2])[:, :300, :3].max(axis=2)[60:340].mean(), 3)

    def test_shaded_colours_stay_near_the_legend(self):
        """A cube of one colour, from a corner: its three faces are told apart, and none is far from the map."""
        import matplotlib
        scene = self.write("cube.xml", CUBE % "")
        for value, span in ((1.0, "-1,0"), (0.5, "-1,1")):
            self.picture(scene, "-n", 0, "--field", "displacement", f"--range={span}", "--view", "iso", "--bare", "--size",
                         "300x300")
            image = pixels(self.path("cube.png"))[:, :, :3]
            expected = 255 * np.array(matplotlib.colormaps["viridis"](value)[:3])
            faces = [image[y, x] for x, y in ((150, 75), (85, 190), (215, 190))]
            for face in faces:
                self.assertGreater((face.sum() / expected.sum()), 0.75)
                self.assertLess((face.sum() / expected.sum()), 1.06)
            self.assertGreater(max(face.sum() for face in faces) / min(face.sum() for face in faces), 1.08)

    def test_what_is_hidden_is_not_seen(self):
        body_at = ('<Node name="%s"><EulerImplicitSolver/><CGLinearSolver/><RegularGridTopology name="grid" n="2 2 2" '
                   'min="%g 0 0" max="%g 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/></Node>')
        scene = self.write("two.xml", '<Node name="root" gravity="0 0 0">' + body_at % ("left", 0, 1)
                           + body_at % ("right", 2, 3) + "</Node>")
        look = ("-n", 0, "--view", "front", "--bare", "--size", "300x100")
        self.picture(scene, *look)
        widths = [np.ptp(np.flatnonzero(body(pixels(self.path("two.png"))).any(axis=0)))]
        for path in ("/left", "/left/", "/right"):
            self.picture(scene, *look, "--hide", path)
            seen = body(pixels(self.path("two.png")))
            self.assertTrue(seen.any())
            widths.append(np.ptp(np.flatnonzero(seen.any(axis=0))))
            self.assertGreater(seen[50].sum() / widths[-1], 0.98, "one body, without a gap")
        self.assertLess(widths[1], 100)
        self.assertGreater(widths[0], 200)

    def test_captions_tell_close_times_apart(self):
        scene = self.write("cube.xml", (CUBE % "").replace('dt="0.01"', 'dt="1e-7"'))
        self.picture(scene, "--at", "1e-7,2e-7,3e-7", "--size", "900x300", "--no-legend", "--field", "none")
        image = pixels(self.path("cube.png"))[:, :, :3]
        strips = [image[-20:, 300 * i + 30:300 * i + 270] for i in range(3)]
        dark = [(strip.max(axis=2) < 120).sum() for strip in strips]
        self.assertGreater(min(dark), 50, "there are letters")
        for a, b in ((0, 1), (1, 2), (0, 2)):
            self.assertGreater(np.abs(strips[a] - strips[b]).max(), 100, "the last digit differs")

    def test_small_pictures_are_left_to_the_bodies(self):
        scene = self.write("cube.xml", CUBE % "")
        self.picture(scene, "-n", 0, "--size", "64x64", "--view", "front", "-o", "small.png")
        self.picture(scene, "-n", 0, "--size", "64x64", "--view", "front", "--bare", "-o", "bare.png")
        small, bare = (body(pixels(self.path(f"{name}.png"))) for name in ("small", "bare"))
        self.assertTrue((small == bare).all())
        self.picture(scene, "-n", 0, "--size", "150x150", "--view", "front")
        self.assertGreater(body(pixels(self.path("cube.png"))[:120]).sum(), 0.25 * 150 * 120)

    def test_many_panels_fit_or_are_refused(self):
        scene = self.write("cube.xml", CUBE % "")
        self.picture(scene, "-n", 0, "--size", "320x64", "--views", "front,back,left,right,top", "--bare")
        seen = body(pixels(self.path("cube.png")))
        for i in range(5):
            self.assertTrue(seen[32, 64 * i + 20:64 * i + 44].all())
        for views, size in ((6, "320x64"), (3000, "64x64")):
            said = self.picture(scene, "-n", 0, "--size", size, "--views", ",".join(["front"] * views), code=2)
            self.assertIn("side by side", said)
        self.picture(scene, "-n", 0, "--views", ",".join(["front"] * 50))
        self.assertEqual(pixels(self.path("cube.png")).shape[1], 3200)
        self.picture(scene, "-n", 0, "--views", ",".join(["front"] * 51), code=2)

    def test_edges_ghost_and_held_nodes_are_seen(self):
        scene = self.write("cube.xml", CUBE % MOVED)
        plain = ("-n", 1, "--view", "iso", "--size", "400x400", "--no-legend", "--field", "none")
        self.picture(scene, *plain)
        without = pixels(self.path("cube.png"))
        for option in ("--edges", "--ghost"):
            self.picture(scene, *plain, option)
            self.assertGreater((pixels(self.path("cube.png")) != without).any(axis=2).sum(), 300, option)
        self.picture(self.write("free.xml", CUBE % ""), "-n", 0, "--view", "bottom", "--size", "400x400", "--no-legend",
                     "--field", "none")
        self.picture(scene, "-n", 0, "--view", "bottom", "--size", "400x400", "--no-legend", "--field", "none")
        dark = [(pixels(self.path(name))[:, :, :3].max(axis=2) < 90).sum() for name in ("free.png", "cube.png")]
        self.assertGreater(dark[1] - dark[0], 150)  # nine dots

    def test_transparent_pictures_have_no_background(self):
        scene = self.write("cube.xml", CUBE % "")
        self.picture(scene, "-n", 0, "--transparent", "--bare", "--size", "300x300", "--view", "front")
        image = pixels(self.path("cube.png"))
        self.assertEqual(image[5, 5, 3], 0)
        self.assertEqual(image[150, 150, 3], 255)

    def test_a_picture_says_what_it_is(self):
        scene = self.write("cube.xml", CUBE % "")
        self.picture(scene, "-n", 0, "--title", "Würfel", "--size", "300x300")
        with Image.open(self.path("cube.png")) as image:
            self.assertEqual(image.text["Software"], "stroma")
            self.assertEqual(image.text["Source"], "cube.xml")
            self.assertEqual(image.text["Title"], "Würfel")


BODY = """<Node name="%s"><EulerImplicitSolver/><CGLinearSolver/><RegularGridTopology name="grid" n="3 2 2" min="%g %g %g" max="%g %g %g"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="1"/></Node>"""


def bodies(*boxes):
    """A scene with blocks: name, corner, sides."""
    return '<Node name="root" gravity="0 0 0" units="m kg s" dt="0.01">' + "".join(
        BODY % (name, *low, *(a + b for a, b in zip(low, sides))) for name, low, sides in boxes) + "</Node>"


class Distant(Case):
    """Bodies that are too far apart for one picture have a panel each; one can be framed."""

    LOOK = ("-n", 0, "--view", "front", "--bare", "--field", "none", "--no-shading")
    BEAM = (1, 0.25, 0.25)

    def panels(self, count, side=400):
        """Width and height of what each panel shows, and which part of that box is covered."""
        image, found = pixels(self.path("two.png")), []
        self.assertEqual(image.shape[:2], (side, count * side))
        for i in range(count):
            seen = body(image[:, side * i:side * (i + 1)])
            rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
            self.assertTrue(len(rows), f"panel {i} is empty")
            found.append((np.ptp(columns) + 1, np.ptp(rows) + 1, seen.sum() / ((np.ptp(columns) + 1) * (np.ptp(rows) + 1))))
        return found

    def test_each_has_a_panel_at_its_own_scale(self):
        full = 400 / MARGIN
        for low, sides in (((1000, 0, 0), self.BEAM), ((0, 0, 50), self.BEAM), ((0, 0, -1000), self.BEAM), ((3, 10, -2), (0.01, 0.0025, 0.0025))):
            with self.subTest(low):
                scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", low, sides)))
                said = self.picture(scene, *self.LOOK, "--size", "800x400")
                self.assertRegex(said, r"left and right are [0-9.]+ m apart")
                for width, height, covered in self.panels(2):
                    self.assertAlmostEqual(width, full, delta=3)
                    self.assertAlmostEqual(height, full / 4, delta=3)
                    self.assertGreater(covered, 0.97)
        self.assertIn("left and right are 10.2 m apart", said)  # the square root of 2 * 2, 9.75 * 9.75 and 1.9975 * 1.9975

    def test_those_that_are_near_share_one(self):
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", (4, 0, 0), self.BEAM)))
        said = self.picture(scene, *self.LOOK, "--size", "400x400")
        self.assertNotIn("apart", said)
        (width, height, covered), = self.panels(1)
        self.assertAlmostEqual(width, 400 / MARGIN, delta=3)
        self.assertAlmostEqual(height, 400 / MARGIN / 5 / 4, delta=2)
        self.assertAlmostEqual(covered, 2 / 5, delta=0.03)

    def test_a_body_that_is_named_is_framed(self):
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", (1.25, 0, 0), self.BEAM), ("far", (1000, 0, 0), self.BEAM)))
        full, shown = 400 / MARGIN, (MARGIN - 1) / 2
        for frames, sizes in ((["/far"], [1]), (["/right", "/far"], [1, 1]), (["/left", "/left/"], [1, 1])):
            self.picture(scene, *self.LOOK, "--size", f"{400 * len(frames)}x400", *(word for path in frames for word in ("--frame", path)))
            for (width, height, covered), size in zip(self.panels(len(frames)), sizes):
                self.assertAlmostEqual(width, size * full, delta=3)
                self.assertAlmostEqual(height, full / 4, delta=3)
                self.assertGreater(covered, 0.97)
        # what is beside the framed body is drawn as far as it is in sight
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", (1.02, 0, 0), self.BEAM)))
        self.picture(scene, *self.LOOK, "--size", "400x400", "--frame", "/left")
        (width, _, _), = self.panels(1)
        self.assertAlmostEqual(width, full * (1 + shown), delta=3)
        # and all of it, however small that is
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("far", (1000, 0, 0), self.BEAM)))
        said = self.picture(scene, *self.LOOK, "--size", "400x400", "--frame", "/")
        self.assertNotIn("apart", said)
        self.assertLess(body(pixels(self.path("two.png"))).sum(), 20)

    def test_panels_say_how_far_and_how_large(self):
        """The words stand above, a bar with its length in each panel; the caption names the body."""
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", (1000, 0, 0), self.BEAM)))
        look = ("-n", 0, "--view", "front", "--field", "none")
        self.picture(scene, *look, "--size", "800x400")
        image = pixels(self.path("two.png"))[:, :, :3].max(axis=2) < 120
        self.assertGreater(image[:25].sum(), 100, "no words above")
        with Image.open(self.path("two.png")) as picture:
            self.assertIn("left and right are 999 m apart", picture.text["Description"])
        lengths = []
        for i in range(2):  # the longest dark run in the lower part of the panel is the bar
            rows = image[300:382, 400 * i + 200:400 * (i + 1)]
            lengths.append(max(len(run) for row in rows for run in "".join("x" if dark else " " for dark in row).split()))
        metre = 400 / MARGIN
        for length in lengths:
            self.assertAlmostEqual(length / metre, 0.25, delta=0.02)

    def test_films_have_the_panels_too(self):
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("right", (1000, 0, 0), self.BEAM)))
        self.assertIn("3 frames", self.picture(scene, "-n", 2, "--animate", "--size", "400x200", "-o", "film.png"))
        with Image.open(self.path("film.png")) as film:
            film.seek(2)
            image = np.asarray(film.convert("RGBA")).astype(int)
        for half in (image[60:150, :200], image[60:150, 200:]):
            self.assertGreater(body(half).sum(), 500)

    def test_a_small_body_near_a_large_one_is_named(self):
        scene = self.write("two.xml", bodies(("left", (0, 0, 0), self.BEAM), ("dust", (1.1, 0, 0), (0.001, 0.001, 0.001))))
        said = self.picture(scene, "-n", 0, "--size", "400x300")
        self.assertIn("note: /dust is less than 6 pixels large in the picture; --frame /dust draws it large", said)
        self.assertNotIn("is less than", self.picture(scene, "-n", 0, "--size", "400x300", "--frame", "/dust"))
        self.assertNotIn("is less than", self.picture(scene, "-n", 0, "--size", "400x300", "--quiet"))


class Films(Case):
    def test_frames_are_counted_and_differ(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        said = self.picture(scene, "-n", 10, "--animate", "--every", 2, "--fps", 10, "--size", "240x180", "-o", "film.png")
        self.assertIn("6 frames", said)
        with Image.open(self.path("film.png")) as film:
            self.assertEqual(film.n_frames, 6)
            frames = []
            for i in range(film.n_frames):
                film.seek(i)
                self.assertAlmostEqual(film.info["duration"], 100)
                frames.append(np.asarray(film.convert("RGB")).astype(int))
        for before, after in zip(frames, frames[1:]):
            self.assertGreater((before != after).any(axis=2).sum(), 50)

    def test_its_last_frame_is_the_picture_of_the_end(self):
        """Ranges and cameras are those of all frames: a range that is given and a body that does not leave its box show it."""
        scene = self.write("cube.xml", CUBE % MOVED)
        look = ("--field", "displacement", "--range", "0,1", "--size", "240x180", "--view", "front", "--bare")
        self.picture(scene, "-n", 4, "--animate", "--every", 1, "-o", "film.png", *look)
        self.picture(scene, "-n", 4, "-o", "end.png", *look)
        with Image.open(self.path("film.png")) as film:
            film.seek(film.n_frames - 1)
            last = np.asarray(film.convert("RGB")).astype(int)
        self.assertTrue((last == pixels(self.path("end.png"))[:, :, :3]).all())


    def test_slow_films_are_slow(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        for fps in (0.1, 0.5, 25, 1000):
            self.picture(scene, "-n", 1, "--animate", "--fps", fps, "--size", "64x64", "-o", "film.png")
            with Image.open(self.path("film.png")) as film:
                self.assertAlmostEqual(film.info["duration"], 1000 / fps, delta=0.01 / fps)

    def test_a_film_of_a_recording_has_the_frames_of_its_run(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        run("run", scene, "-n", 10, "--record", "kept", "--quiet", folder=self.folder)
        look = ("--animate", "--every", 4, "--size", "200x150")
        for name, what in (("live", (scene, "-n", 10)), ("kept", ("kept",))):
            self.assertIn("4 frames", self.picture(*what, *look, "-o", f"{name}.png"))  # 0, 4, 8 and 10
        frames = []
        for name in ("live", "kept"):
            with Image.open(self.path(f"{name}.png")) as film:
                frames.append([])
                for i in range(film.n_frames):
                    film.seek(i)
                    frames[-1].append(np.asarray(film.convert("RGB")).astype(int))
        for live, kept in zip(*frames):
            self.assertTrue((live == kept).all())
        run("run", scene, "-n", 101, "--record", "long", "--quiet", folder=self.folder)
        for what in ((scene, "-n", 101), ("long",)):
            self.assertIn("52 frames", self.picture(*what, "--animate", "--size", "64x64", "--bare", "-o", "film.png"))
        self.assertIn("101 frames", self.picture(scene, "--animate", "--size", "64x64", "--bare", "-o", "film.png"))


class Recordings(Case):
    def test_are_drawn_like_the_run(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        run("run", scene, "-n", 6, "--record", "kept", "--quiet", folder=self.folder)
        self.picture(scene, "-n", 6, "--size", "300x200", "-o", "live.png")
        self.picture("kept", "--size", "300x200")
        live, kept = pixels(self.path("live.png")), pixels(self.path("kept.png"))
        self.assertTrue((live == kept).all())
        self.picture("kept", "--at", "0.03", "--size", "300x200", "-o", "half.png")
        self.picture(scene, "--at", "0.03", "--size", "300x200", "-o", "half_live.png")
        self.assertTrue((pixels(self.path("half.png")) == pixels(self.path("half_live.png"))).all())
        self.assertFalse((pixels(self.path("half.png")) == kept).all())
        said = self.picture("kept", "--animate", "--size", "200x150", "-o", "film.png")
        self.assertIn("7 frames", said)

    def test_a_checkpoint_is_drawn_like_the_run(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        run("run", scene, "-n", 6, "--record", "kept", "--quiet", folder=self.folder)
        for more in ((), ("-n", 3)):
            self.picture(scene, "-n", 6 + (3 if more else 0), "--size", "300x200", "-o", "live.png")
            self.picture(scene, "--restart", "kept/last.checkpoint", *more, "--size", "300x200", "-o", "kept.png")
            self.assertTrue((pixels(self.path("live.png")) == pixels(self.path("kept.png"))).all())
        self.assertIn("nothing", self.picture(scene, "--restart", "nothing", code=2))
        self.assertIn("a recording is not run", self.picture("kept", "--restart", "kept/last.checkpoint", code=2))

    def test_times_stand_as_asked_of_a_run_too(self):
        scene = self.write("cube.xml", CUBE % FALLING)
        run("run", scene, "-n", 6, "--record", "kept", "--quiet", folder=self.folder)
        look = ("--at", "end,0.02,start,0.02", "--size", "480x120", "--bare")
        self.picture(scene, "-n", 6, *look, "-o", "live.png")
        self.picture("kept", *look, "-o", "kept.png")
        live, kept = pixels(self.path("live.png")), pixels(self.path("kept.png"))
        self.assertTrue((live == kept).all())
        self.assertTrue((live[:, 120:240] == live[:, 360:]).all())
        self.assertFalse((live[:, :120] == live[:, 240:360]).all())

    def test_instants_stand_side_by_side(self):
        scene = self.write("cube.xml", CUBE % MOVED)
        self.picture(scene, "-n", 1, "--at", "start,end", "--view", "side", "--bare", "--size", "800x400")
        image = pixels(self.path("cube.png"))
        start, end = body(image[:, :400]), body(image[:, 400:])
        widths = [np.ptp(np.flatnonzero(half.any(axis=0))) + 1 for half in (start, end)]
        self.assertAlmostEqual(widths[1] / widths[0], 1.5, delta=0.02)


CARVED = (CUBE % """<BoxROI name="below" box="-1 -1 -1 2 0.1 2"/><FixedProjectiveConstraint indices="@below.indices"/>
  <CarvingRegion name="knife" box="0.6 0.6 -9 9 9 9" velocity="0 0 0" begin="0.02" end="0.02"/>
  <TopologicalChangeProcessor useDataInputs="true" timeToRemove="0.045" hexahedraToRemove="3"/>""")


class ChangedMeshes(Case):
    """A cube of eight cells that stands still: a column of two goes before the third step, another cell before the sixth."""

    def test_each_state_has_its_own_cells(self):
        """Of one layer of four cells, seen from before it: three are left, then two."""
        look = ("--view", "front", "--bare", "--size", "300x100", "--field", "displacement", "--hide", "/cube/knife")
        scene = self.write("flat.xml", CARVED.replace('n="3 3 3"', 'n="3 3 2"').replace('hexahedraToRemove="3"', 'hexahedraToRemove="1"'))
        self.picture(scene, "-n", 8, "--at", "end,0.03,start", *look)
        image = body(pixels(self.path("flat.png")))
        seen = [image[:, i * 100:(i + 1) * 100].sum() for i in range(3)]
        self.assertAlmostEqual(seen[1] / seen[2], 3 / 4, delta=0.02)
        self.assertAlmostEqual(seen[0] / seen[2], 2 / 4, delta=0.02)

    def test_recordings_are_drawn_like_the_run(self):
        moves = CARVED.replace('velocity="0 0 0"', 'velocity="0 5 0"').replace('end="0.02"/>', 'end="0.5"/>')
        scene = self.write("cube.xml", moves.replace('gravity="0 0 0"', 'gravity="2 0 0"'))
        run("run", scene, "-n", 8, "--record", "kept", "--quiet", folder=self.folder)
        look = ("--size", "480x120")
        for name, what in (("live", (scene, "-n", 8)), ("kept", ("kept",))):
            self.picture(*what, "--at", "0.06,start,0.03,end", *look, "-o", f"{name}.png")
            self.assertIn("9 frames", self.picture(*what, "--animate", *look, "-o", f"{name}_film.png"))
        self.assertTrue((pixels(self.path("live.png")) == pixels(self.path("kept.png"))).all())
        with Image.open(self.path("live_film.png")) as live, Image.open(self.path("kept_film.png")) as kept:
            for i in range(9):
                live.seek(i), kept.seek(i)
                self.assertTrue((np.asarray(live.convert("RGB")) == np.asarray(kept.convert("RGB"))).all(), i)
        # and so is what every run leaves
        run("run", scene, "-n", 8, "--quiet", folder=self.folder)
        self.picture("results/cube/last", "--at", "0.06,start,0.03,end", *look, "-o", "last.png")
        self.assertTrue((pixels(self.path("live.png")) == pixels(self.path("last.png"))).all())

    def test_a_region_is_drawn_where_it_was(self):
        """A box of 0.2 m beside the cube goes up by 0.5 m in six steps; then one that cuts a corner."""
        look = ("--at", "start,0.03,end", "--size", "480x120", "--view", "front", "--field", "none", "--bare")
        for name, region in (("beside", 'box="1.1 0 0  1.3 0.2 0.2"'), ("corner", 'box="0.9 0.4 0.9  1.1 0.6 1.1"')):
            scene = self.write(f"{name}.xml", CUBE % f'<CarvingRegion {region} velocity="0 8.33333 0"/>')
            run("run", scene, "-n", 6, "--record", name, "--quiet", folder=self.folder)
            run("run", scene, "-n", 6, "--quiet", folder=self.folder)
            self.picture(scene, "-n", 6, *look, "-o", "live.png")
            live = pixels(self.path("live.png"))
            for kept in (name, f"results/{name}/last"):
                self.picture(kept, *look, "-o", "kept.png")
                self.assertTrue((live == pixels(self.path("kept.png"))).all(), kept)
            if name == "beside":
                tops = [np.flatnonzero(body(part)[:, -30:].any(axis=1)).min() for part in np.split(live, 3, axis=1)]
                self.assertGreater(tops[0] - tops[1], 5)
                self.assertAlmostEqual(tops[1] - tops[2], tops[0] - tops[1], delta=2)

    def test_a_film_takes_no_scene_for_each_change(self):
        """Of a block of 9 000 cells that loses some in each of ten steps, against its end alone."""
        scene = self.write("block.xml", """<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver iterations="1"/>
          <RegularGridTopology n="41 16 16" min="0 0 0" max="4 1.5 1.5"/><MechanicalObject/><UniformMass totalMass="1"/>
          <HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/><CarvingRegion box="3.92 -9 -9 9 9 9" velocity="-10 0 0"/></Node>""")
        most = {}
        for name, more in (("end", ()), ("film", ("--animate", "--every", 1))):
            child = subprocess.Popen([STROMA, "picture", scene, "-n", "10", "--size", "64x64", "--field", "none", "-o", f"{name}.png", *map(str, more)],
                                     cwd=self.folder, env=WITHOUT_DISPLAY, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            _, status, used = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(child.returncode, 0, name)
            most[name] = used.ru_maxrss / 1024
        self.assertLess(most["film"] - most["end"], 40)


class Refusals(Case):
    def refused(self, *arguments, code=2):
        before = set(os.listdir(self.folder))
        said = self.picture(*arguments, code=code)
        self.assertEqual(set(os.listdir(self.folder)), before, "something was written")
        return said

    def test_name_what_was_expected(self):
        scene = self.write("cube.xml", CUBE % "")
        for arguments, words in ((("--field", "vonMisses"), "did you mean 'vonMises'"), (("--colours", "virdis"), "viridis"),
                                 (("--view", "frnt"), "front"), (("--range", "3,1"), "LOW below HIGH"),
                                 (("--size", "10x10"), "64 to 7680"), (("--cut", "w=3"), "x=VALUE"), (("--every", 2), "--animate"),
                                 (("--at", "soon"), "start or end"), (("-o", "cube.jpg"), ".png"), (("-n", 1, "--until", 1), "exclude"),
                                 (("--hide", "/cub"), "/cube"), (("--frame", "/cub"), "/cube"), (("--frame", "/cube", "--hide", "/cube"), "nothing of /cube is drawn"), (("-n", 1, "--at", 5), "larger -n"), (("--until", 1, "--at", "0.5,1.5"), "--at 1.5: the run ends at 1"),
                                 (("--at=-1",), "a time from 0 on"), (("--fps", 0.01, "--animate"), "0.1 or more"),
                                 (("--fps", 1e6, "--animate"), "1000 or less"),
                                 (("--range", "1,1.0000000000000002"), "tells its ends apart"),
                                 (("--range", "0,1e-40"), "tells its ends apart"), (("--range=-1e308,1e308",), "tells its ends")):
            with self.subTest(arguments):
                self.assertIn(words, self.refused(scene, *arguments))

    def test_fields_are_listed(self):
        said = self.refused(self.write("cube.xml", CUBE % ""), "--field", "help", code=0)
        for name in ("displacement", "velocity", "vonMises", "none"):
            self.assertIn(name, said)

    def test_another_file_is_not_written_over(self):
        scene = self.write("cube.xml", CUBE % "")
        self.write("cube.png", "an image of my own")
        self.assertIn("no picture of stroma", self.refused(scene, "-n", 0))
        with open(self.path("cube.png"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "an image of my own")
        self.picture(scene, "-n", 0, "-o", "cube.png", "--size", "100x100")  # asked for by name
        self.picture(scene, "-n", 0, "--size", "120x100")                    # its own
        self.assertEqual(pixels(self.path("cube.png")).shape[1], 120)

    def test_no_picture_of_a_run_without_a_result(self):
        scene = self.write("cube.xml", EXPLODING)
        said = self.refused(scene, "-n", 300, code=3)
        self.assertIn("no result", said)
        self.picture(scene, "-n", 300, "--anyway", "--size", "400x300", code=3)
        image = pixels(self.path("cube.png"))[:, :, :3]
        red = (image[:, :, 0] > 150) & (image[:, :, 1] < 90) & (image[:, :, 2] < 90)
        self.assertGreater(red[:60].sum(), 50, "the warning is in the picture")

    def test_a_time_beyond_the_end_is_refused_before_the_run(self):
        scene = self.write("cube.xml", CUBE % FALLING)  # a run of hours
        self.assertIn("larger -n", self.refused(scene, "-n", 100000000, "--at", "start,2000000"))

    def test_a_picture_that_cannot_be_written_is_told_of_a_run_without_a_result_too(self):
        scene = self.write("cube.xml", EXPLODING)
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        environment = {**WITHOUT_DISPLAY, "MESA_SHADER_CACHE_DISABLE": "true"}
        result = subprocess.run([STROMA, "picture", scene, "-n", "300", "--anyway"], capture_output=True, text=True,
                                cwd=self.folder, env=environment, timeout=LONGEST, preexec_fn=limit, restore_signals=False)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("cube.png", result.stderr)

    def test_a_cut_beside_the_body_is_refused(self):
        scene = self.write("cube.xml", CUBE % "")
        said = self.picture(scene, "-n", "0", "--cut", "x=9", code=2)
        self.assertIn("--cut x=9: what is drawn lies between x = 0 and 1", said)
        self.assertFalse(os.path.exists(self.path("cube.png")))
        self.picture(scene, "-n", "0", "--cut", "x=0.9")

    def test_a_machine_without_a_renderer_is_told_the_package(self):
        """EGL finds no driver where its list of vendors is empty."""
        scene = self.write("cube.xml", CUBE % "")
        self.write("none", "")
        environment = {**WITHOUT_DISPLAY, "__EGL_VENDOR_LIBRARY_FILENAMES": self.path("none")}
        result = subprocess.run([STROMA, "picture", scene, "-n", "0"], capture_output=True, text=True, cwd=self.folder,
                                env=environment, timeout=LONGEST)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("libgl1-mesa-dri", result.stderr)
        self.assertFalse(os.path.exists(self.path("cube.png")))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
