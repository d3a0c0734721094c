#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Installs a build into a folder, moves that elsewhere and works with it from an empty folder; no installed file may know a path of
the sources or of the build. A build that is not complete is refused before anything is installed. A part that is missing is named
with what brings it. Usage: test_install.py TREE BUILD"""
import gzip
import os
import re
import shutil
import subprocess
import sys
import tempfile

TREE, BUILD = (os.path.abspath(path) for path in sys.argv[1:3])
sys.dont_write_bytecode = True  # what stood beside make_leg.py would be installed with it
sys.path[:0] = [os.path.join(TREE, "tests", "support"), os.path.join(TREE, "scenes", "meshes")]
from kept import kept  # noqa: E402

ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith("STROMA_")}
ENVIRONMENT.update(LC_ALL="C", PYTHONDONTWRITEBYTECODE="1")


def run(*command, code=0, **options):
    result = subprocess.run(command, capture_output=True, text=True, timeout=1800, env=ENVIRONMENT, **options)
    assert result.returncode == code, f"{' '.join(command)} ended with {result.returncode}\n{result.stdout}{result.stderr}"
    return result.stdout + result.stderr


def files(folder):
    for place, _, names in os.walk(folder):
        for name in names:
            yield os.path.join(place, name)


def check_refusal(folder):
    """The list of parts with another build folder in place of this one: empty at first, then whole but for one part."""
    empty = os.path.join(folder, "empty")
    os.makedirs(empty)
    for name in ("check_build.cmake", "parts.built"):
        with open(os.path.join(BUILD, name), encoding="utf-8") as file, \
             open(os.path.join(empty, name), "w", encoding="utf-8") as copy:
            copy.write(file.read().replace(BUILD, empty))
    with open(os.path.join(empty, "parts.built"), encoding="utf-8") as file:
        parts = [line.rstrip("\n").split("\t") for line in file]
    assert len(parts) > 20, parts

    def refusal():
        text = run("cmake", "-P", os.path.join(empty, "check_build.cmake"), code=1)
        return " ".join(text.split())

    said = refusal()
    assert "Nothing was installed" in said and all(part[0] in said for part in parts), said
    assert f'cmake --build "{empty}" --target stroma_all' in said, said
    for _, _, path in parts:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii"):
            pass
    run("cmake", "-P", os.path.join(empty, "check_build.cmake"))
    os.remove(next(path for name, _, path in parts if name == "hyperelasticity"))
    assert "Not built yet: hyperelasticity Build the rest" in refusal()


def check_files(prefix):
    """No path of this machine, and only libraries of the installation or the system."""
    programs = 0
    for path in files(prefix):
        with open(path, "rb") as file:
            content = file.read()
        for wrong in (TREE, BUILD):
            assert wrong.encode() not in content, f"{path} knows {wrong}"
        if content[:4] != b"\x7fELF":
            continue
        programs += 1
        for search in re.findall(r"R(?:UN)?PATH\).*\[(.*)\]", run("readelf", "-d", path)):
            assert all(part.startswith("$ORIGIN") for part in search.split(":")), f"{path} looks in {search}"
        libraries = run("ldd", path)
        assert "not found" not in libraries, f"{path}:\n{libraries}"
        assert re.search(r"libstroma\S* => " + re.escape(prefix), libraries) or os.path.basename(path).startswith("libstroma"), \
            f"{path} does not use the installed library:\n{libraries}"
    assert programs > 20, programs


def check_commands(prefix, here):
    stroma, scenes = os.path.join(prefix, "bin", "stroma"), os.path.join(prefix, "share", "stroma", "scenes")
    built = os.path.join(BUILD, "bin", "stroma")
    assert run(stroma, "list", cwd=here) == run(built, "list", cwd=here)
    organ = ("run", os.path.join(scenes, "examples", "organ.xml"), "-n", "5")
    states = [re.findall(r"state hash ([0-9a-f]{16})", run(program, *organ, cwd=here)) for program in (stroma, built)]
    assert states[0] and states[0] == states[1], states
    assert os.path.getsize(os.path.join(here, "results", "organ", "organ.pvd")), "no ParaView files in the current folder"
    run(stroma, "run", os.path.join(scenes, "examples", "organ_condensed.xml"), "-n", "2", "--quiet", cwd=here)
    run(stroma, "bench", "--help", cwd=here)
    package = os.path.join(prefix, "lib", "python3", "dist-packages")
    if os.path.exists(package):
        run("/usr/bin/env", f"PYTHONPATH={package}", "/usr/bin/python3", os.path.join(scenes, "python", "first_scene.py"), cwd=here)
    image = os.path.join(scenes, "meshes", "leg.nii.gz")
    mesh = ("mesh", image, "-o", "leg.msh", "--scale", "0.001", "--cell-size", "0.03", "--free-volume")
    if os.path.exists(os.path.join(prefix, "lib", "stroma", "meshing.so")):
        run(stroma, *mesh, cwd=here)
        assert os.path.getsize(os.path.join(here, "leg.msh")) > 10000
    if os.path.exists(os.path.join(prefix, "lib", "stroma", "view.so")):
        run(stroma, "view", organ[1], "--export", "organ.html", "-n", "3", cwd=here)
        assert os.path.getsize(os.path.join(here, "organ.html")) > 100000
    check_missing(prefix, here, stroma, (stroma, *mesh), (stroma, *organ))


def check_missing(prefix, here, stroma, mesh, organ):
    """Without a module and a reader: what brings them, of packages and where nothing is known of them."""
    modules = next(os.path.dirname(path) for path in files(prefix) if path.endswith("vtk_io.so"))
    os.remove(os.path.join(modules, "vtk_io.so"))
    os.remove(os.path.join(modules, "read_label_image"))
    assert "the module vtk_io is not here" in run(*organ, code=2, cwd=here)
    assert "tools/setup build" in run(*mesh, code=2, cwd=here)
    with open(os.path.join(modules, "parts.packages"), "w", encoding="ascii") as file:
        file.write("vtk_io\tstroma-vtk\nread_label_image\tstroma-vtk\n")
    for command in (organ, mesh):
        assert "install the package stroma-vtk" in run(*command, code=2, cwd=here), command
    assert "VTKExporter" in run(stroma, "list", "VTKExporter", cwd=here)


def check_image():
    """The sample image is what scenes/meshes/make_leg.py makes."""
    import make_leg
    with tempfile.TemporaryDirectory() as folder:
        made = os.path.join(folder, "leg.nii")
        make_leg.write_nifti(made, *make_leg.leg(2.0), 2.0)
        with open(made, "rb") as file, gzip.open(os.path.join(TREE, "scenes", "meshes", "leg.nii.gz")) as kept:
            assert file.read() == kept.read(), "scenes/meshes/leg.nii.gz is not what make_leg.py makes"


def main():
    check_image()
    # The list of a person's own installation, which this one overwrites.
    with tempfile.TemporaryDirectory() as folder, kept(os.path.join(BUILD, "install_manifest.txt")):
        check_refusal(folder)
        first, prefix, here = (os.path.join(folder, name) for name in ("first", "moved to a place", "elsewhere"))
        run("cmake", "--install", BUILD, "--prefix", first)
        shutil.move(first, prefix)
        os.makedirs(here)
        check_files(prefix)
        check_commands(prefix, here)
        print("installed, moved, used; nothing refers to the sources or the build")


if __name__ == "__main__":
    main()
