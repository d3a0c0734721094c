#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Packs a build with cpack and looks into the Debian packages: which package has what, what each depends on, that unpacked side by
side they work, and that the command's alone names the package of what it lacks. Usage: test_package.py TREE BUILD"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

TREE, BUILD = (os.path.abspath(path) for path in sys.argv[1:3])
PACKAGES = {"stroma", "stroma-vtk", "stroma-mesh", "stroma-solvers", "stroma-dev", "python3-stroma"}
WHERE = {  # a file, whatever the folder of libraries is called: its package
    "bin/stroma": "stroma", "stroma/view.so": "stroma", "stroma/vtk_io.index": "stroma", "stroma/parts.packages": "stroma",
    "scenes/meshes/leg.nii.gz": "stroma", "scenes/regression/list": "stroma", "doc/stroma/docs/install.md": "stroma",
    "stroma/vtk_io.so": "stroma-vtk", "stroma/picture.so": "stroma-vtk", "stroma/read_label_image": "stroma-vtk", "stroma/read_vtk_mesh": "stroma-vtk",
    "stroma/meshing.so": "stroma-mesh", "stroma/direct_solvers.so": "stroma-solvers",
    "cmake/stroma/stroma-config.cmake": "stroma-dev", "stroma/stroma-index": "stroma-dev", "libstroma.so": "stroma-dev",
    "python3/dist-packages/stroma/__init__.py": "python3-stroma",
    "framework/scene/component.h": "stroma-dev"}
# cpack asks what each file is by `cmake -E env LC_ALL=C file NAME`, and to start cmake takes it longest: a shell starts the program.
START = '/bin/sh;-c;[ "$1 $2 $3" = "-E env LC_ALL=C" ] && shift 3 || set -- cmake "$@"\nexec "$@";sh'
HEAVY = re.compile(r"vtk|cholmod|blas|libgmp|libmpfr|libcgal")  # what the command's own package must not want


def run(*command, code=0, **options):
    result = subprocess.run(command, capture_output=True, text=True, timeout=1800, **options)
    assert result.returncode == code, f"{' '.join(command)} ended with {result.returncode}\n{result.stdout}{result.stderr}"
    return result.stdout + result.stderr


def fields(deb):
    lines = run("dpkg-deb", "--field", deb).split("\n")
    return dict(line.split(": ", 1) for line in lines if ": " in line and not line.startswith(" "))


def check_contents(debs):
    owners = {}
    for package, deb in debs.items():
        listing = run("dpkg-deb", "--contents", deb)
        for line in listing.strip().split("\n"):
            assert " root/root " in line, line
            path = line.split(" ./", 1)[1].split(" -> ")[0]
            if not path.endswith("/"):
                assert path not in owners, f"{path} is in {package} and {owners[path]}"
                owners[path] = package
        for name in ("copyright", "changelog.gz"):
            assert owners.get(f"usr/share/doc/{package}/{name}") == package, f"{package} has no {name}"
    for end, package in WHERE.items():
        found = {owner for path, owner in owners.items() if path.endswith("/" + end)}
        assert found == {package}, f"{end} is in {found or 'no package'}, expected {package}"


def check_dependencies(debs):
    version = None
    for package, deb in debs.items():
        control = fields(deb)
        version = version or control["Version"]
        depends = control["Depends"]
        assert control["Package"] == package and control["Architecture"] == "amd64", control
        if package == "stroma":
            assert not HEAVY.search(depends) and "libtbb" in depends and "libc6" in depends, depends
            assert "stroma-vtk" in control["Recommends"], control
        else:
            assert f"stroma (= {version})" in depends, f"{package}: {depends}"
    assert "libvtk9" in fields(debs["stroma-vtk"])["Depends"]
    assert "libcholmod3" in fields(debs["stroma-solvers"])["Depends"]
    assert "libeigen3-dev" in fields(debs["stroma-dev"])["Depends"]


def check_commands(debs, folder):
    """Unpacked, the whole also works outside /usr where libraries are found from the place of the command."""
    root = os.path.join(folder, "root")
    stroma, scenes = os.path.join(root, "usr/bin/stroma"), os.path.join(root, "usr/share/stroma/scenes")
    run("dpkg-deb", "-x", debs["stroma"], root)
    organ = (stroma, "run", os.path.join(scenes, "examples/organ.xml"), "-n", "2", "--quiet")
    mesh = (stroma, "mesh", os.path.join(scenes, "meshes/leg.nii.gz"), "-o", "leg.msh", "--scale", "0.001", "--cell-size", "0.03",
            "--free-volume")
    run(stroma, "run", os.path.join(scenes, "examples/cantilever.xml"), "-n", "2", "--quiet", cwd=folder)
    assert "install the package stroma-vtk" in run(*organ, code=2, cwd=folder)
    run("dpkg-deb", "-x", debs["stroma-vtk"], root)
    run(*organ, cwd=folder)
    run("dpkg-deb", "-x", debs["python3-stroma"], root)
    run("/usr/bin/python3", "-c", f"import stroma; stroma.load({organ[2]!r}, observers=False).step()", cwd=folder,
        env={**os.environ, "PYTHONPATH": os.path.join(root, "usr/lib/python3/dist-packages")})
    assert "install the package stroma-mesh" in run(*mesh, code=2, cwd=folder)
    condensed = (stroma, "run", os.path.join(scenes, "examples/organ_condensed.xml"), "-n", "2", "--quiet")
    assert "install the package stroma-solvers" in run(*condensed, code=2, cwd=folder)
    for package in ("stroma-mesh", "stroma-solvers"):
        run("dpkg-deb", "-x", debs[package], root)
    run(*condensed, cwd=folder)
    run(*mesh, cwd=folder)


def main():
    for program in ("cpack", "dpkg-deb", "dpkg-shlibdeps"):
        if not shutil.which(program):
            print(f"no {program} here")
            sys.exit(77)
    with open(os.path.join(BUILD, "check_build.cmake"), encoding="utf-8") as file:
        if 'set(left_out "")' not in file.read():
            print("this build is not whole")
            sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        run("cpack", "-G", "DEB", "--config", os.path.join(BUILD, "CPackConfig.cmake"), "-B", folder,
            "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none", "-D", "CPACK_THREADS=1", "-D", f"CMAKE_COMMAND={START}", cwd=folder,
            env={**os.environ, "LC_ALL": "C"})
        debs = {os.path.basename(path).split("_")[0]: path for path in glob.glob(os.path.join(folder, "**", "*.deb"), recursive=True)}
        assert set(debs) == PACKAGES, sorted(debs)
        check_contents(debs)
        check_dependencies(debs)
        check_commands(debs, folder)
        print(f"{len(debs)} packages with what they should have")


if __name__ == "__main__":
    main()
