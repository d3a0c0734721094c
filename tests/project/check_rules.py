#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the rules of the tree: which folder may include which, a licence line in every source, names of tests, no path of one
machine in any text, what lies at the top. Usage: check_rules.py TREE, or check_rules.py --self-test (plants violations and expects each to be found)."""
import os
import re

from planted import run, tree_files

# A folder of framework/ and those it may include.
FRAMEWORK = {
    "scene": {"scene"},
    "mesh": {"scene", "mesh"},
    "algebra": {"scene", "algebra"},
    "collision": {"scene", "collision"},
    "mechanics": {"scene", "mesh", "algebra", "mechanics"},
    "fem": {"scene", "mesh", "algebra", "mechanics", "fem"},
    "simulation": {"scene", "mesh", "algebra", "mechanics", "fem", "simulation"},
}
# Libraries that only some folders may include: header pattern, folders.
GUARDED = [
    (re.compile(r"vtk\w+\.h$"), ("components/vtk_io/", "components/topology/read_vtk_mesh.cpp", "tools/mesh/image_io/", "tools/picture/", "tests/")),
    (re.compile(r"^(EGL|GL)/"), ("tools/picture/",)),
    (re.compile(r"^CGAL/"), ("tools/mesh/meshing/",)),
    (re.compile(r"gmsh\.h(_cwrap)?$"), ("tests/",)),
    (re.compile(r"tinyxml2\.h$"), ("framework/scene/", "tests/")),
    (re.compile(r"^boost/(asio|beast)"), ("tools/view/", "tests/")),
    (re.compile(r"cholmod\.h$"), ("components/direct_solvers/", "components/condensation/", "tests/")),
]
# Who may include the private headers of a family besides the family: its own tests (a folder of its name) and these.
READERS_OF_FAMILIES = {
    "topology": ("tests/mesh/", "tests/meshing/", "tests/support/",  # read meshes back, cut cells
                 "tests/fuzz/"),
    "condensation": ("tests/fuzz/",),
}
# Tools whose library another one links.
TOOLS_FOR_TOOLS = {
    "command": {"mesh", "view", "picture", "drawing", "sweep", "stress", "profile", "session", "plan", "units", "checks",
                "platform", "sofa"},
    "view": {"drawing", "session", "plan", "scene_writer", "checks", "units", "platform"},
    "picture": {"drawing", "units", "platform"},
    "sweep": {"session", "platform"},
    "stress": {"sweep", "session", "units", "checks"},
    "python": {"checks", "command", "picture", "session", "plan", "platform", "sofa", "view"},
    "live": {"platform"},
    "bench": {"platform"},
    "recordings": {"platform"},
    "sofa": {"platform"},
    "session": {"checks", "mesh_report", "units"},
    "scene_writer": {"session"},
    "plan": {"units"},
    "checks": {"units"},
}
# What lies at the top besides folders: what a run or a test leaves there is no part of the tree.
TOP = {".clang-format", ".clang-tidy", ".gitignore", "CHANGELOG.md", "CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md"}
SOURCE = re.compile(r"(\.(h|cpp|py|cmake|in|xml|sh)|CMakeLists\.txt)$")
BINARY = re.compile(r"\.(png|gif|gz|vtu|pdf|so|o|pyc)$|^tests/fuzz/corpus/")  # fuzzers write any bytes
MACHINE_PATH = re.compile(r"(?<![\w.$}*\]/-])/(work|tmp|home)/")
TEST = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+),\s*(\w+)\)", re.M)
NAME_OF_TEST = re.compile(r"[A-Z][A-Za-z0-9]*$")
# a component in its module, also by a helper of the registration
REGISTERED = re.compile(r'\badd\w*(?:<[^;()]*>)?\(\s*"([A-Z]\w+)"')
LITERAL = re.compile(r'"((?:\\.|[^"\\\n])*)"')
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def included_problem(path, quoted, header, exists):
    """Why the file at `path` may not include `header`, or None."""
    top = path.split("/")
    for pattern, folders in GUARDED:
        if pattern.search(header) and not path.startswith(folders):
            return f"includes {header}, which only {', '.join(folders)} may"
    if not quoted:
        return None
    target = header.split("/")
    if top[0] == "framework":
        if len(target) < 3 or target[0] != "framework":
            return f'includes "{header}": write "framework/<folder>/..."'
        if target[1] not in FRAMEWORK.get(top[1], set()):
            return f"framework/{top[1]} must not include framework/{target[1]}"
    elif top[0] == "components":
        if target[0] != "framework" and target[:2] != top[:2]:
            return f'includes "{header}": a component includes framework/ and its own family only'
    elif target[0] == "components":
        family = target[1]
        if not path.startswith((f"tests/{family}/", *READERS_OF_FAMILIES.get(family, ()))):
            return f'includes "{header}": the private headers of a family are for the family and its tests'
    elif top[0] == "tools":
        others = {"tools/" + other for other in TOOLS_FOR_TOOLS.get(top[1], ())}
        own_folder = "/".join(top[:-1])
        if (target[0] != "framework" and target[:2] != top[:2] and "/".join(target[:2]) not in others
                and not exists(own_folder + "/" + header)):
            return f'includes "{header}": a tool includes framework/ and its own folder only'
    return None


def badly_named_tests(path, text):
    """Tests are in test_*.cpp; suites and cases are in CamelCase, without underscores."""
    for match in TEST.finditer(text):
        if not os.path.basename(path).startswith("test_"):
            yield match.start(), "has a test and is not called test_*.cpp"
        for name in match.groups():
            if not NAME_OF_TEST.match(name):
                yield match.start(), f"the name of a test, {name}, is not in CamelCase"


def shared_files(text):
    """Two runs of the tests, of two checkouts or after a crash, must not meet in one file of the machine."""
    for match in re.finditer(r"TempDir\(\)|temp_directory_path\(\)", text):
        line = text.count("\n", 0, match.start())
        statement = "\n".join(text.split("\n")[max(line - 1, 0):line + 3])
        if "getpid" not in statement and "XXXXXX" not in statement:
            yield match.start(), "a file that another run finds: take a folder of its own (tests/support/folder_fixture.h)"


def known_components(text, names):
    """The engine asks for parts to be played, not for components by name."""
    for match in LITERAL.finditer(text):
        line = text[text.rfind("\n", 0, match.start()) + 1:match.start()]
        if line.lstrip().startswith(("#include", "//")):
            continue
        for word in re.findall(r"\w+", match.group(1)):
            if word in names:
                yield match.start(), f"the engine knows {word} by name: ask for a part (framework/scene/usual_component.h)"


def is_source(path, text):
    return bool(SOURCE.search(path)) or text.startswith("#!")


def problems(tree):
    found, counted, components, engine = [], 0, set(), {}
    for path in tree_files(tree):
        if "/" not in path and path not in TOP:
            found.append(f"{path}: does not belong at the top of the tree")
        if BINARY.search(path):
            continue
        with open(os.path.join(tree, path), encoding="utf-8", errors="replace") as file:
            text = file.read()
        counted += 1
        if is_source(path, text) and "SPDX-License-Identifier: LGPL-2.1-or-later" not in "\n".join(text.split("\n")[:3]):
            found.append(f"{path}: no SPDX licence line at the top")
        for match in MACHINE_PATH.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            found.append(f"{path}:{line}: a path of one machine: {text[match.start():match.start() + 30].split()[0]}")
        for start, why in badly_named_tests(path, text) if path.endswith(".cpp") else []:
            found.append(f"{path}:{text.count(chr(10), 0, start) + 1}: {why}")
        for start, why in shared_files(text) if path.startswith("tests/") and path.endswith((".h", ".cpp")) else []:
            found.append(f"{path}:{text.count(chr(10), 0, start) + 1}: {why}")
        if path.startswith("components/") and path.endswith(".cpp"):
            components.update(REGISTERED.findall(text[max(text.find("STROMA_COMPONENT("), 0):]))
        if path.startswith("framework/") and path.endswith((".h", ".cpp")):
            engine[path] = text
        if path.endswith((".h", ".cpp")):
            for match in INCLUDE.finditer(text):
                why = included_problem(path, match.group(1) == '"', match.group(2),
                                       lambda other: os.path.exists(os.path.join(tree, other)))
                if why:
                    found.append(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {why}")
    for path, text in engine.items():
        for start, why in known_components(text, components):
            found.append(f"{path}:{text.count(chr(10), 0, start) + 1}: {why}")
    return found, counted


LICENCE = "// SPDX-License-Identifier: LGPL-2.1-or-later\n"
PLANTED = {  # path: (text, part of the expected finding, or None where there is nothing to find)
    "framework/scene/a.h": (LICENCE + '#include "framework/mesh/mesh.h"\n', "framework/scene must not include framework/mesh"),
    "framework/mesh/b.cpp": (LICENCE + '#include "framework/simulation/s.h"\n', "must not include framework/simulation"),
    "framework/algebra/c.h": (LICENCE + '#include "framework/mechanics/state.h"\n', "must not include framework/mechanics"),
    "framework/fem/d.h": (LICENCE + '#include "d_private.h"\n', 'write "framework/<folder>/..."'),
    "framework/fem/e.cpp": (LICENCE + "#include <vtkPolyData.h>\n", "which only components/vtk_io/"),
    "components/elasticity/f.cpp": (LICENCE + '#include "components/mechanics/g.h"\n', "its own family only"),
    "components/elasticity/g.h": (LICENCE + '#include "framework/fem/d.h"\n#include "components/elasticity/h.h"\n', None),
    "tests/elasticity/q.cpp": (LICENCE + '#include "components/elasticity/g.h"\n', None),
    "tests/validation/r.cpp": (LICENCE + '#include "components/elasticity/g.h"\n', "for the family and its tests"),
    "framework/fem/s.cpp": (LICENCE + '#include "components/elasticity/g.h"\n', 'write "framework/<folder>/..."'),
    "tools/bench/t.cpp": (LICENCE + '#include "components/elasticity/g.h"\n', "for the family and its tests"),
    "tools/command/u.cpp": (LICENCE + '#include "tools/mesh/o.h"\n', None),
    "tools/picture/v.cpp": (LICENCE + '#include <vtkActor.h>\n#include <EGL/egl.h>\n#include "tools/drawing/w.h"\n', None),
    "tools/picture/x.cpp": (LICENCE + '#include "tools/view/w.h"\n', "its own folder only"),
    "tools/drawing/w.h": (LICENCE + '#include "tools/picture/w.h"\n', "its own folder only"),
    "tools/view/w.h": (LICENCE + '#include "tools/drawing/w.h"\n#include <EGL/egl.h>\n', "which only tools/picture/"),
    "tools/mesh/v.cpp": (LICENCE + '#include "tools/command/i.h"\n', "its own folder only"),
    "tools/command/h.cpp": (LICENCE + '#include "components/elasticity/g.h"\n', "for the family and its tests"),
    "tools/command/i.cpp": (LICENCE + '#include "i.h"\n#include "framework/scene/node.h"\n', None),
    "tools/command/i.h": (LICENCE, None),
    "tools/mesh/meshing/o.cpp": (LICENCE + '#include <CGAL/Random.h>\n#include "tools/mesh/o.h"\n#include "n.h"\n', None),
    "tools/mesh/meshing/n.h": (LICENCE, None),
    "tools/mesh/o.h": (LICENCE + '#include "tools/bench/p.h"\n', "its own folder only"),
    "framework/mesh/p.cpp": (LICENCE + "#include <CGAL/Random.h>\n", "which only tools/mesh/meshing/"),
    "components/loads/a.cpp": (LICENCE + 'STROMA_COMPONENT(a) { factory.add<A>("SomeForceField", "pushes"); }\n', None),
    "framework/simulation/a.cpp": (LICENCE + 'const char* text = "use a SomeForceField";\n', "knows SomeForceField by name"),
    "components/loads/b.cpp": (LICENCE + 'STROMA_COMPONENT(b) { const auto add = adder(factory); add("OtherForceField", 1); }\n', None),
    "framework/simulation/c.cpp": (LICENCE + 'const char* text = "use an OtherForceField";\n', "knows OtherForceField by name"),
    "framework/simulation/b.cpp": (LICENCE + '// "SomeForceField"\nconst char* text = "use SomeForceFields";\n', None),
    "framework/simulation/j.cpp": (LICENCE + '#include "framework/fem/d.h"\n#include <vector>\n', None),
    "tests/scene/test_w.cpp": (LICENCE + "TEST(Suite, CaseOne) {}\nTEST_F(Suite2, Case) {}\n", None),
    "tests/scene/test_x.cpp": (LICENCE + "TEST(Suite, case) {}\n", "case, is not in CamelCase"),
    "tests/scene/test_y.cpp": (LICENCE + "TEST_P(Suite_2, Case) {}\n", "Suite_2, is not in CamelCase"),
    "tests/scene/z.cpp": (LICENCE + "TEST(Suite, Case) {}\n", "is not called test_*.cpp"),
    "tests/scene/test_i.cpp": (LICENCE + 'auto file = testing::TempDir() + "/state";\n', "a file that another run finds"),
    "tests/scene/test_j.cpp": (LICENCE + 'auto file = temp_directory_path() / ("state" + to_string(getpid()));\n', None),
    "tests/scene/k.cpp": ('#include "anything.h"\n', "no SPDX"),
    "tools/l": ("#!/bin/sh\n\n\n\n# SPDX-License-Identifier: LGPL-2.1-or-later\n", "no SPDX"),
    "docs/m.md": ("see /" + "tmp/x and a/" + "tmp/x\n", "a path of one machine"),
    "x.msh": ("$MeshFormat\n", "does not belong at the top"),
    "README.md": ("# A tree\n", None),
    "docs/n.md": ("work/energy, a/work/b and https://host/home/page\n", None),
}


if __name__ == "__main__":
    run(__doc__, PLANTED, problems)
