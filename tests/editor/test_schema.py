#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The schemas of `stroma schema` accept every scene of the tree and refuse, as `stroma check` does, what is wrong. Judged by
libxml2 (xmllint), by Xerces and Jing (jing), and in Emacs (nxml-mode) as a person types.
Usage: test_schema.py TREE STROMA MODULE.so [test...]. Ends with 77 where a program is missing, which says which."""
import glob
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from broken_scenes import GOOD, MISTAKES, broken

TREE, STROMA, MODULE = (os.path.abspath(path) for path in sys.argv[1:4])
NXML = os.path.join(os.path.dirname(os.path.abspath(__file__)), "nxml.el")
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="stroma.xsd"'


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=1500, **options)


def scenes():
    found = sorted(glob.glob(os.path.join(TREE, "scenes", "**", "*.xml"), recursive=True))
    # made of a component that is built outside the tree
    return [scene for scene in found if "out_of_tree_module" not in scene]


def pressures():
    """A force per area, in the ways that the reader of units has for products, quotients, powers and brackets."""
    for force, length in (("N", "m"), ("mN", "mm"), ("uN", "µm"), ("dyn", "cm"), ("lbf", "in")):
        squares = [f"{length}{power}" for power in ("2", "^2", "**2", "^(2)", "**(2)", "²", "^02")]
        squares += [f"({length})^2", f"({length} {length})", f"({length}*{length})", f"({length} . {length})", f"({length}2)",
                    f"( {length} )2", f"({length}/(1/{length}))", f"({length}.{length})", f"({length}·{length})"]
        yield from (f"{force}{sign}{square}" for square in squares for sign in ("/", " / ", "/ ", " /"))
        yield from (f"{force}{sign}{length}{power}" for sign in (" ", "*", " * ", ".", "·", " ⋅ ")
                    for power in ("-2", "^-2", "**-2", "^(-2)", "⁻²"))
        yield from (f"{force}/{length}/{length}", f"({force})/({length})/{length}", f"({force}/{length}2)", f"({force})(1/{length}2)",
                    f"{force}(1/{length}^2)", f"{force} (1 / {length}2)", f"{length}-2{force}", f"{length}^-2 {force}", f"(({force}))/{length}2",
                    f"1/({length}2/{force})", f"/({length}2 {force}-1)", f"({force}/{length})/{length}", f"(1/{length})({force}/{length})",
                    f"({length}-1)2{force}")


def made_values():
    """Elements, attributes and values, of which `stroma check` takes most."""
    law, grid = "TetrahedronFEMForceField", "RegularGridTopology"
    units = list(pressures())
    yield [(law, "youngModulus", f"10 {unit}") for unit in units]
    yield [(law, "youngModulus", number + unit) for number in ("10", "+1.5e3 ", "1/3 ", ".5", "5.") for unit in units[::17]]
    yield [(law, "poissonRatio", value) for value in ("30 %", "30%", "1/3", "0.3", "+.3", "1/3 %", "3e1 %")]
    yield [("Node", "gravity", value) for value in (
        "0 -9.81 0 m/s2", "0 -9.81 0 m/s^2", "-9.81 m s-2", "0 -9.81 0 m/(s s)", "0 m/s2 -9.81 m/s2, 0 m/s2", "0,-981,0 cm/s**2", "1/2 m/s2",
        "0 -98/10 0", "-9.81", "0m/s² -9.81m/s² 0m/s²", "0 -9.81 0 m/s/s")]
    yield [(grid, "max", value) for value in (
        "10mm 10mm 10mm", "10 mm 10 mm 10 mm", "10, 10, 10 mm", "1/2 1/2 1/2", "1/2 1 3 cm", " 10 10 10mm ", "10 mm,10 mm,10 mm,", "1 1 1 µm")]
    yield [("MechanicalObject", "position", value) for value in (
        "1 2 3 mm", "1mm 2mm 3mm", ", 1 2 3, 4 5 6 mm", "1/2 2 3 4 5 6/7 mm", "1/2 1 1", "1 2 3 mm,", "1 m 2 m 3 m 1 mm 2 mm 3 mm")]
    yield [("Node", "dt", value) for value in ("1/100 s", "10 ms", "10ms", "1/60 s", "1/60", "0.01s", "1e1 ms")]


class Schemas(unittest.TestCase):
    """Schemas and scenes in a folder of their own."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="stroma_schema_")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.xsd, cls.rnc = (os.path.join(cls.folder, "stroma." + kind) for kind in ("xsd", "rnc"))
        for kind, file in (("xsd", cls.xsd), ("rnc", cls.rnc)):
            made = run(STROMA, "schema", "--format", kind, "-o", file)
            assert made.returncode == 0, made.stderr

    def write(self, name, text):
        file = os.path.join(self.folder, name)
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
        return file

    # ---- the judges: for each file the lines that they refuse ----

    def lines_refused(self, output, files):
        refused = {file: [] for file in files}
        for line in output.splitlines():
            match = re.match(r"(.+?\.xml):(\d+):", line)
            if match and match.group(1) in refused:
                refused[match.group(1)].append(int(match.group(2)))
        return refused

    def xmllint(self, files, schema=None):
        done = run("xmllint", "--noout", "--schema", schema or self.xsd, *files)
        self.assertIn(done.returncode, (0, 3, 4), done.stderr[:2000])
        return self.lines_refused(done.stderr, files)

    def jing(self, files, schema):
        # a moment's work: compiling it well takes longer than doing it
        done = run("jing", *(["-c"] if schema.endswith(".rnc") else []), schema, *files,
                   env={**os.environ, "JAVA_TOOL_OPTIONS": "-XX:TieredStopAtLevel=1 -XX:+UseSerialGC"})
        self.assertIn(done.returncode, (0, 1), done.stderr[:2000])
        self.assertNotIn(schema, done.stdout, "the schema itself is refused")
        return self.lines_refused(done.stdout, files)

    def judges(self):
        return {"xmllint": self.xmllint,
                "Xerces": lambda files: self.jing(files, self.xsd),
                "Jing": lambda files: self.jing(files, self.rnc)}

    def check(self, file, *options):
        return run(STROMA, "check", file, "--json", *options)


class Acceptance(Schemas):
    def test_every_scene_of_the_tree(self):
        files = scenes()
        self.assertGreater(len(files), 50)
        for judge, refused in self.judges().items():
            for file, lines in refused(files).items():
                self.assertEqual(lines, [], f"{judge} refuses {file}")

    def test_how_values_may_be_written(self):
        files = {}
        for right, other in (('totalMass="0.08"', 'totalMass=" +8.e-2 "'), ('n="5 3 3"', 'n="5, 3 3"'),
                             ('indices="0, 1 2"', 'indices="0-2 3-9-3,10,11"'), ('method="polar"', 'method="@fem2.method"'),
                             ('totalForce="0 0 0"', 'totalForce="@end.box"'), ('activated="true"', 'activated="0"'),
                             ('iterations="25"', 'iterations="@other.iterations"'), ('keyTimes="0 1"', 'keyTimes="0,1"'),
                             ('preconditioner="jacobi"', 'preconditioner="@ssor"')):
            self.assertIn(right, GOOD)
            files[self.write(f"written_{len(files)}.xml", GOOD.replace(right, other))] = other
        for judge, refused in self.judges().items():
            for file, lines in refused(list(files)).items():
                self.assertEqual(lines, [], f"{judge} refuses {files[file]}")

    def test_units(self):
        text = GOOD
        for right, other in (('totalMass="0.08"', 'totalMass="80 g"'), ('youngModulus="10000"', 'youngModulus="10 kPa"'),
                             ('dt="0.01"', 'dt="1/100 s"'), ('gravity="0 -9.81 0"', 'gravity="-9.81 m/s^2"'),
                             ('max="0.2 0.05 0.05"', 'max="200 50 50 mm"'), ('keyTimes="0 1"', 'keyTimes="0 s 1000 ms"'),
                             ('rayleighStiffness="0.02"', 'rayleighStiffness="2e1 ms"'),
                             ('rayleighMass="0.5"', 'rayleighMass="30 1/min"'), ('poissonRatio="0.3"', 'poissonRatio="30 %"'),
                             ('box="-0.01 -1 -1  0.01 1 1"', 'box="-10 -1000 -1000  10 1000 1000 mm"')):
            self.assertIn(right, text)
            text = text.replace(right, other)
        files = [self.write("units.xml", text), self.write("marks.xml", text.replace("10 kPa", "0.01 N/mm²"))]
        for file in files:
            self.assertEqual(self.check(file).returncode, 0, self.check(file).stdout)
        for judge, refused in self.judges().items():
            self.assertEqual(refused(files), {file: [] for file in files}, judge)

    def test_units_as_the_grammar_makes_them(self):
        """Whatever `stroma check` takes as a value with a unit, the schemas take; made of all ways to write a unit."""
        cases = [each for kind in made_values() for each in kind]
        self.assertGreater(len(cases), 600)
        lines = [f'<{element} {attribute}="{value}"/>' for element, attribute, value in cases]
        file = self.write("made.xml", "<Node>\n" + "\n".join(lines) + "\n</Node>\n")
        problems = json.loads(self.check(file).stdout)["problems"]
        taken = []
        for number, (_, attribute, value) in enumerate(cases):
            said = [each for each in problems if each["line"] == number + 2 and each.get("attribute", attribute) == attribute
                    and re.search("unit|number|value|list|divi|bracket|power|finite", each["message"])
                    and each["severity"] == "error" and attribute in json.dumps(each)]
            if not said:
                taken.append(number + 2)
        self.assertGreater(len(taken), 500, problems[:5])
        for judge, refused in self.judges().items():
            wrong = sorted(set(refused([file])[file]) & set(taken))
            self.assertEqual([lines[line - 2] for line in wrong], [], judge)

    def test_long_lists_with_a_unit(self):
        numbers = " ".join(["1 2.5 3e-2"] * 4000)
        file = self.write("long.xml", f'<Node><MechanicalObject position="{numbers} mm"/></Node>')
        for judge, refused in self.judges().items():
            self.assertEqual(refused([file]), {file: []}, judge)

    def test_components_of_a_module_given_by_its_path(self):
        component = "FickleForceField"
        file = self.write("module.xml", f'<Node>\n<{component}/>\n</Node>\n')
        self.assertEqual(self.xmllint([file]), {file: [2]})
        schema = os.path.join(self.folder, "more.xsd")
        self.assertEqual(run(STROMA, "schema", "--module", MODULE, "-o", schema).returncode, 0)
        self.assertEqual(self.xmllint([file], schema), {file: []})

    def test_a_scene_that_names_its_schema_is_the_same_scene(self):
        plain = self.write("plain.xml", GOOD)
        named = self.write("named.xml", GOOD.replace('<Node name="root"', f'<Node {XSI} name="root"'))
        model = self.write("model.xml", GOOD.replace("<Node name=\"root\"", '<?xml-model href="stroma.rnc"\n'
                                                     'type="application/relax-ng-compact-syntax"?><Node name="root"'))
        for file in (plain, named, model):
            said = self.check(file)
            self.assertEqual(said.returncode, 0, said.stdout)
            self.assertNotIn("xsi", said.stdout)
        for judge, refused in self.judges().items():
            self.assertEqual(refused([named, model]), {named: [], model: []}, judge)
        hashes = {json.loads(run(STROMA, "run", file, "-n", "2", "--json", cwd=self.folder).stdout)["state_hash"]
                  for file in (plain, named, model)}
        self.assertEqual(len(hashes), 1, hashes)

    def test_an_included_file_may_name_it_too(self):
        for root in ("Node", "Group"):
            self.write("part.xml", f'<{root} {XSI}>\n<BoxROI name="b" box="0 0 0 1 1 1" position="0 0 0"/>\n</{root}>\n')
            whole = self.write("whole.xml", f'<Node {XSI}>\n<include href="part.xml"/>\n</Node>\n')
            self.assertEqual(self.check(whole).returncode, 0, self.check(whole).stdout)


class Refusal(Schemas):
    def test_the_good_scene_is_good(self):
        file = self.write("good.xml", GOOD)
        for judge, refused in self.judges().items():
            self.assertEqual(refused([file]), {file: []}, judge)
        said = self.check(file)
        self.assertEqual(said.returncode, 0, said.stdout)

    def test_schemas_and_check_refuse_the_same(self):
        files = {}
        for number, mistake in enumerate(MISTAKES):
            text, line = broken(mistake)
            files[self.write(f"broken_{number}.xml", text)] = (mistake[0], line)
        self.assertGreaterEqual(len({text for text, _ in files.values()}), 30)
        for judge, refused in self.judges().items():
            for file, lines in refused(list(files)).items():
                what, line = files[file]
                with self.subTest(judge=judge, mistake=what):
                    self.assertIn(line, lines)
        for file, (what, line) in files.items():
            with self.subTest(judge="stroma check", mistake=what):
                said = self.check(file)
                self.assertEqual(said.returncode, 2)
                errors = [each["line"] for each in json.loads(said.stdout)["problems"] if each["severity"] == "error"]
                self.assertIn(line, errors)

    def test_relax_ng_tells_what_goes_together(self):
        both = GOOD.replace('totalMass="0.08"', 'vertexMass="1" mass="1"')
        file = self.write("together.xml", both)
        self.assertNotEqual(self.jing([file], self.rnc), {file: []})
        self.assertEqual(self.check(file).returncode, 2)


class Text(Schemas):
    def test_it_has_the_version_and_is_always_the_same(self):
        version = run(STROMA, "--version").stdout.split()[1]
        for kind, file in (("xsd", self.xsd), ("rnc", self.rnc)):
            with open(file, encoding="utf-8") as text:
                first = text.read()
            self.assertIn(f"Stroma {version}", first)
            self.assertEqual(run(STROMA, "schema", "--format", kind).stdout, first)
            names = re.findall(r'<xs:complexType name="(.*?)"', first)[1:] or re.findall(r"^type\.(\S+) =", first, re.M)[1:]
            self.assertGreater(len(names), 100)
            self.assertEqual(names, sorted(names))

    def test_every_attribute_says_what_it_is(self):
        import xml.etree.ElementTree as tree
        xs = "{http://www.w3.org/2001/XMLSchema}"
        root = tree.parse(self.xsd).getroot()
        self.assertEqual(root.get("version"), run(STROMA, "--version").stdout.split()[1])
        for each in list(root.iter(xs + "attribute")) + list(root.iter(xs + "element")):
            if each.get("ref"):
                continue
            help_text = each.findtext(f"{xs}annotation/{xs}documentation")
            self.assertTrue(help_text and len(help_text) > 5, each.get("name"))

    def test_what_cannot_be_done_is_said(self):
        for arguments, expected in ((["--format", "dtd"], "expected xsd or rnc"), (["-o", self.xsd + "/x"], "cannot make the folder"),
                                    (["--module", "no_such.so"], "no_such.so"), (["extra"], "too many")):
            said = run(STROMA, "schema", *arguments)
            self.assertEqual(said.returncode, 2, arguments)
            self.assertIn(expected, said.stderr)


    def test_only_a_schema_is_replaced(self):
        scene = self.write("mine.xml", GOOD)
        said = run(STROMA, "schema", "-o", scene)
        self.assertEqual(said.returncode, 2)
        self.assertIn("is no schema", said.stderr)
        with open(scene, encoding="utf-8") as text:
            self.assertEqual(text.read(), GOOD)
        place = self.write("place.xsd", "")
        for kind in ("xsd", "rnc", "xsd", "xsd"):
            self.assertEqual(run(STROMA, "schema", "--format", kind, "-o", place).returncode, 0)
        with open(place, encoding="utf-8") as text, open(self.xsd, encoding="utf-8") as first:
            self.assertEqual(text.read(), first.read())

    @unittest.skipUnless(os.path.exists("/dev/full"), "there is no /dev/full")
    def test_a_full_disk_is_said(self):
        said = run(STROMA, "schema", "-o", "/dev/full")
        self.assertEqual(said.returncode, 4)
        self.assertIn("No space left", said.stderr)


class Emacs(Schemas):
    def emacs(self, text, *places, schema=None):
        file = self.write("typed.xml", text)
        done = run("emacs", "--batch", "-Q", "-l", NXML, schema or self.rnc, file, *places)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout.splitlines()[-1])

    def test_mistakes_are_underlined_where_they_stand(self):
        self.assertEqual(self.emacs(GOOD)["marked"], [])
        for right, wrong, marked in (('totalMass="0.08"', 'totalMas="0.08"', "totalMas"),
                                     ("<UniformMass ", "<UniformMas ", "UniformMas"),
                                     ('method="polar"', 'method="pollar"', "pollar"),
                                     ('poissonRatio="0.3"', 'poissonRatio="0.6"', "0.6"),
                                     ('gravity="0 -9.81 0"', 'gravity="0 -9.81"', "0 -9.81")):
            found = self.emacs(GOOD.replace(right, wrong))["marked"]
            line = GOOD[:GOOD.index(right)].count("\n") + 1
            self.assertEqual([(each["line"], each["text"]) for each in found], [(line, marked)], found)

    def test_it_finds_the_schema_that_a_file_beside_the_scene_names(self):
        self.write("schemas.xml", '<locatingRules xmlns="http://thaiopensource.com/ns/locating-rules/1.0">\n'
                                  '<uri pattern="*.xml" uri="stroma.rnc"/>\n</locatingRules>\n')
        found = self.emacs(GOOD.replace("totalMass", "totalMas"), schema="-")["marked"]
        self.assertEqual([each["text"] for each in found], ["totalMas"], found)

    def test_names_and_words_are_completed(self):
        def offered(typed):
            """What stands behind `typed` at the end of the body."""
            place = '<Monitor name="watch" indices="0, 1 2"/>'
            return self.emacs(GOOD.replace(place, typed), typed)["offered"][0]
        page = json.loads(run(STROMA, "doc", "TetrahedronFEMForceField", "--json").stdout)
        words = next(each["choices"] for each in page["attributes"] if each["name"] == "method")
        self.assertIn("polar", words)
        components = offered("<Tetra")
        self.assertIn("TetrahedronFEMForceField", components)
        self.assertNotIn("BoxROI", components)
        self.assertEqual(offered("<MeshMatrixMass mass"), ["massDensity"])
        self.assertEqual(offered('<TetrahedronFEMForceField name="more" method="'),
                         sorted(words))
        self.assertEqual(offered('<Node act'), ["activated"])


NEEDED = {"Acceptance": ["xmllint", "jing"], "Refusal": ["xmllint", "jing"], "Text": [], "Emacs": ["emacs"]}

if __name__ == "__main__":
    names = sys.argv[4:] or list(NEEDED)
    missing = sorted({program for name in names for program in NEEDED[name.split(".")[0]] if not shutil.which(program)})
    if missing:
        print(f"skipped: {', '.join(missing)} not installed")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *names])
