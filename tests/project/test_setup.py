#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/setup without doing any of its work: usage, and what it says when packages are missing and cannot be installed.
Programs that it calls are replaced by small ones in a folder at the front of PATH."""
import os
import shutil
import subprocess
import sys
import tempfile

# The small `dpkg-query`, which is asked with options for the states of packages: each is installed, or all but one.
INSTALLED = 'for name; do case $name in -*) ;; *) echo "$name installed" ;; esac; done'
NOT_GMSH = 'for name; do case $name in -* | *libgmsh*) ;; *) echo "$name installed" ;; esac; done; exit 1'
# Each is installed but those in MISSING.
BUT_MISSING = 'for name; do case " $MISSING " in *" $name "*) ;; *) case $name in -*) ;; *) echo "$name installed" ;; esac ;; esac; done'
# What the small `stroma` does when it is asked for a picture.
PICTURE = 'mkdir -p results/organ; [ "$PICTURE_CODE" != 0 ] || echo x > results/organ/organ.png; exit ${PICTURE_CODE:-0}'
# And the small `cmake`: it fails where it is told to, and installs the command.
CMAKE = """case "$1" in
  --build) exit ${BUILD_CODE:-0} ;;
  --install) mkdir -p "$4/bin"; cp "$2/bin/stroma" "$4/bin"; printf '%s/bin/stroma' "$4" > "$2/install_manifest.txt" ;;
esac
exit ${CMAKE_CODE:-0}"""


def check_install(stages, folder, build):
    """A folder that cannot be written is refused before the build; what is printed removes an installation, also with a space."""
    file = os.path.join(folder, "a file")
    with open(file, "w", encoding="ascii"):
        pass
    done, result = stages("install", os.path.join(file, "below"), code=1)
    assert done == [] and f"sudo cmake --install {build} --prefix {folder}/a\\ file/below --strip" in result.stderr, (done, result)
    prefix = os.path.join(folder, "my prefix")
    result = stages("install", prefix)[1]
    removal = next(line for line in result.stdout.split("\n") if line.startswith("To remove it:")).partition(":")[2]
    assert os.path.exists(os.path.join(prefix, "bin", "stroma")), result
    os.remove(os.path.join(build, "install_manifest.txt"))  # an installation elsewhere has another
    subprocess.run(["bash", "-c", removal], check=True)
    assert not [names for _, _, names in os.walk(prefix) if names], removal


def check_tests(stages, build):
    """The checks of the tree come before the build and keep it from beginning; then what has changed since the last tests."""
    checks = ["check_rules.py", "check_text.py", "check_budgets.py"]
    done, result = stages("test", "-y", code=1, PYTHON_CODE="1")
    assert done == checks[:1] and result.stdout.endswith("\n0 passed, 1 failed\n"), (done, result)
    whole = [*checks, "cmake", "all", "all", "summarise_tests.py"]
    assert stages("test", "-y")[0] == whole
    for name, place in (("test_scene", "bin"), ("test_fem", "bin"), ("fem.so", "lib/stroma/v4"), ("further_fem.so", "lib/stroma/v4"),
                        ("picture.so", "lib/stroma")):
        path = os.path.join(build, place, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii"):
            pass
        os.utime(path, (1, 1) if name.startswith("test_") else None)
    later = os.stat(os.path.join(build, "tests.xml")).st_mtime + 2
    os.utime(os.path.join(build, "lib/stroma/v4/fem.so"), (later, later))
    done = stages("test", "-y")[0]
    assert done == [*whole[:4], "all", "^(fem)$", "^(fem)$", "summarise_tests.py"], done
    # the second module of a folder
    with open(os.path.join(build, "lib/stroma/modules.sources"), "w", encoding="ascii") as file:
        file.write("fem\t/components/fem/one.cpp\nfurther_fem\t/components/fem/two.cpp\t/components/fem/three.cpp\n")
    later = os.stat(os.path.join(build, "tests.xml")).st_mtime + 2
    os.utime(os.path.join(build, "lib/stroma/v4/further_fem.so"), (later, later))
    done = stages("test", "-y")[0]
    assert done == [*whole[:4], "all", "^(fem)$", "^(fem)$", "summarise_tests.py"], done


def check_packages(stages, build, log, calls):
    """Most packages are installed while the engine is compiled, what tests need alone while the rest is; then nothing is left to wait for."""
    late = {"libvtk9-dev": "stroma", "chromium": "all"}  # package: what is being compiled
    waits = "; ".join(f'case "$*" in *{package}*) for i in $(seq 10000); do ! grep -q "^cmake --build .* {target}$" {log} || break; sleep 0.02; done ;; esac'
                      for package, target in late.items())
    calls("apt-get", f'{waits}; echo "apt-get ${{*##* }}" >> {log}; exit ${{APT_CODE:-0}}')
    missing = {"MISSING": "g++ libvtk9-dev chromium"}
    engine = ["apt-get", "cmake", "stroma", "apt-get", "cmake"]
    checks = ["check_rules.py", "check_text.py", "check_budgets.py"]
    done, result = stages("test", "-y", **missing)
    assert done == [engine[0], *checks, *engine[1:], "all", "apt-get", "all", "summarise_tests.py"], (done, result)
    os.remove(os.path.join(build, "tests.xml"))
    assert stages("build", "-y", **missing)[0] == [*engine, "stroma_all"]
    assert stages("build", "-y", MISSING="g++")[0] == ["apt-get", "cmake", "stroma_all"]
    # what fails unseen is done again where it is seen: the lists updated, and then given up
    done, result = stages("build", "-y", code=3, MISSING="libvtk9-dev", APT_CODE="100")
    assert done == ["cmake", "stroma", *4 * ["apt-get"]] and "could not install" in result.stderr, (done, result)


def check_stages(setup):
    """`run` shows the first scene before it builds the rest; --quick ends there; what cannot be built is said."""
    with tempfile.TemporaryDirectory() as folder:
        tree, build, log = (os.path.join(folder, name) for name in ("tree", "build", "log"))
        for place in ("tree/tools", "build/bin", "programs"):
            os.makedirs(os.path.join(folder, place))
        shutil.copy(setup, os.path.join(tree, "tools", "setup"))
        ctest = 'for a; do case $a in *.xml) echo "<testsuite/>" > "$a";; esac; done; for last; do :; done; [ "$last" != --no-tests=error ] || last=all'
        programs = {"ctest": f'{ctest}; echo "ctest $last" >> {log}',
                    "python3": f'echo "python3 ${{1##*/}}" >> {log}; exit ${{PYTHON_CODE:-0}}',
                    "dpkg-query": BUT_MISSING, "id": "echo 0", "cmake": f'echo "cmake $@" >> {log}; {CMAKE}',
                    "../build/bin/stroma": f'echo "stroma $@" >> {log}; [ "$1" != picture ] || {{ {PICTURE}; }}'}
        def calls(program, body):
            path = os.path.join(folder, "programs", program)
            with open(path, "w", encoding="ascii") as file:
                file.write("#!/bin/sh\n" + body + "\n")
            os.chmod(path, 0o755)

        for program, body in programs.items():
            calls(program, body)
        environment = dict(os.environ, PATH=os.path.join(folder, "programs") + ":" + os.environ["PATH"], BUILD=build)

        def stages(*arguments, code=0, **more):
            with open(log, "w", encoding="ascii"):
                pass
            result = subprocess.run(["bash", os.path.join(tree, "tools", "setup"), *arguments], capture_output=True, text=True,
                                    env=dict(environment, **more), stdin=subprocess.DEVNULL, timeout=600)
            assert result.returncode == code, result
            with open(log, encoding="ascii") as file:
                lines = file.read().splitlines()
            # the word of the line that tells what is done
            which = {"cmake --build": -1, "stroma picture": 1, "ctest": 1, "python3": 1}
            return [line.split()[which.get(" ".join(line.split()[:2]), which.get(line.split()[0], 0))] for line in lines], result

        shown = ["cmake", "first_scene", "stroma", "picture"]
        done, result = stages("run", "-y", PICTURE_CODE="0")
        assert done == shown + ["stroma_all"] and "Picture:" in result.stdout, result
        # no picture is no reason to stop, and one of an earlier run is not this one's
        done, result = stages("run", "-y", PICTURE_CODE="4")
        assert done == shown + ["stroma_all"] and "No picture could be made" in result.stdout, result
        assert "Picture:" not in result.stdout, result
        done, result = stages("run", "-y", "--quick")
        assert done == shown and "tools/setup build" in result.stdout, result
        assert f"BUILD={build} " in result.stdout, result
        assert stages("build")[0] == ["cmake", "stroma_all"]
        result = stages("build", "--no-view", "-j2", code=1, BUILD_CODE="1")[1]
        assert f"BUILD={build} {tree}/tools/setup build --no-view -j2 tries again" in result.stderr, result
        check_packages(stages, build, log, calls)
        check_tests(stages, build)
        check_install(stages, folder, build)
        done, result = stages("install", os.path.join(folder, "prefix"), code=1, CMAKE_CODE="1")
        assert done == ["cmake"] and "Configuring failed" in result.stderr, result


def main():
    setup = os.path.join(sys.argv[1], "tools", "setup")
    assert subprocess.run(["bash", "-n", setup]).returncode == 0
    assert subprocess.run(["bash", "-n", os.path.join(sys.argv[1], ".ci", "run")]).returncode == 0

    def run(*arguments, programs=None, terminal=subprocess.DEVNULL):
        with tempfile.TemporaryDirectory() as folder:
            for name, body in (programs or {}).items():
                path = os.path.join(folder, name)
                with open(path, "w", encoding="ascii") as file:
                    file.write("#!/bin/sh\n" + body + "\n")
                os.chmod(path, 0o755)
            environment = dict(os.environ, PATH=folder + ":" + os.environ["PATH"])
            return subprocess.run(["bash", setup, *arguments], capture_output=True, text=True, env=environment,
                                  stdin=terminal, timeout=600)

    result = run("--help")
    assert result.returncode == 0 and "tools/setup run" in result.stdout, result
    for wrong in ((), ("tset",), ("test", "--fast"), ("test", "-j", "many"), ("test", "-j"), ("test", "-j", "0"), ("test", "-j00"),
                  ("view", "--no-view"), ("run", "folder"), ("install", "one", "two")):
        result = run(*wrong)
        assert result.returncode == 2 and "tools/setup" in result.stderr, (wrong, result)

    none_installed = {"dpkg-query": "exit 1"}
    result = run("install", programs={**none_installed, "id": "echo 1000", "sudo": "exit 1"})
    assert result.returncode == 3, result
    assert "apt-get install" in result.stderr and "libvtk9-dev" in result.stderr and "nobody" in result.stderr, result

    result = run("install", programs={**none_installed, "id": "echo 0", "apt-get": "exit 100"})
    assert result.returncode == 3 and "could not install" in result.stderr, result

    # At a terminal the password is asked for first, and where there are no rights nothing is begun.
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "log")
        asked = {"dpkg-query": NOT_GMSH, "id": "echo 1000", "apt-get": f'echo "apt-get ${{*##* }}" >> {log}'}
        sudo = f'case "$1" in -v) echo "sudo -v" >> {log}; exit $RIGHTS ;; -n) shift ;; esac; exec "$@"'
        ours, terminal = os.openpty()
        for rights, code, calls in (("0", 0, ["sudo -v", "apt-get libgmsh-dev"]), ("1", 3, ["sudo -v"])):
            with open(log, "w", encoding="ascii"):
                pass
            result = run("install", "-y", programs={**asked, "sudo": sudo.replace("$RIGHTS", rights)}, terminal=terminal)
            with open(log, encoding="ascii") as file:
                assert file.read().splitlines() == calls and result.returncode == code, (rights, result)
            assert ("sudo gave no root rights" in result.stderr) == (code == 3), result
        os.close(ours), os.close(terminal)

    # As root without a terminal it installs, once, everything that is missing.
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "log")
        result = run("install", programs={"dpkg-query": NOT_GMSH,
                                          "id": "echo 0", "apt-get": f'echo "$@" >> {log}'})
        assert result.returncode == 0, result
        with open(log, encoding="ascii") as file:
            calls = file.read().strip().split("\n")
        assert len(calls) == 1 and calls[0].endswith("libgmsh-dev") and "install -y" in calls[0], calls

    result = run("install", programs={"dpkg-query": INSTALLED, "apt-get": "exit 1", "sudo": "exit 1"})
    assert result.returncode == 0 and result.stdout == "", result
    # Which instruction sets are built: the machine's, all when asked for, what was built before as long as it has it.
    installed = {"dpkg-query": INSTALLED, "cmake": 'case "$*" in *--build*) exit 1;; *) echo "$@" >&3;; esac',
                 "python3": "exit 0"}  # the checks of the tree

    def configured(*arguments, before=None):
        """The arguments of the call of cmake that configures."""
        with tempfile.TemporaryDirectory() as folder:
            log, build = os.path.join(folder, "log"), os.path.join(folder, "build")
            if before:
                os.makedirs(build)
                with open(os.path.join(build, "CMakeCache.txt"), "w", encoding="ascii") as file:
                    file.write(f"STROMA_LEVELS:STRING={before}\nSTROMA_TESTS:BOOL=ON\n")
            programs = {**installed, "cmake": installed["cmake"].replace(">&3", f">>{log}")}
            os.environ["BUILD"] = build
            run(*arguments, programs=programs)
            del os.environ["BUILD"]
            with open(log, encoding="ascii") as file:
                return file.read().split("\n")[0]

    def levels(*arguments, before=None):
        return configured(*arguments, before=before).split("-DSTROMA_LEVELS=")[1].split()[0]

    machine, every = levels("test", "-y"), "x86-64-v2;x86-64-v3;x86-64-v4"
    assert machine in every.split(";"), machine
    assert levels("run", "-y") == machine
    assert levels("test", "-y", "--all-levels") == every
    assert levels("run", "-y", before=every) == every
    assert levels("test", "-y", before="x86-64-v1") == machine
    assert levels("package", "-y") == every and levels("build") == machine
    assert "-DCMAKE_INSTALL_PREFIX=/usr" in configured("package") and "INSTALL_PREFIX" not in configured("run")
    check_stages(setup)
    print("tools/setup says and does what it should")


if __name__ == "__main__":
    main()
