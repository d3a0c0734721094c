# SPDX-License-Identifier: LGPL-2.1-or-later
"""The command `stroma` on a scene in Python: python3 -m Sofa.command run scene.py -n 100. The command starts this by itself."""
import atexit
import functools
import gc
import io
import os
import signal
import socket
import sys

from . import _catalogue, _engine, _events, _force_field, _messages, _scene_file
from ._mirror import Mirror
from .constants import Key


def traced(method):
    """What it raises carries its traceback to the command."""

    @functools.wraps(method)
    def call(*arguments):
        try:
            return method(*arguments)
        except BaseException as error:
            raise error

    return call


class Program:
    """Plays a scene for the command: describes it, and takes part in its steps. `root`: a tree that is there already."""

    def __init__(self, root=None, words=()):
        self._words = words
        self._given, self._root, self._mirror, self._running, self._steps = root, None, None, None, 0
        self.changes_tree = self._has_started = False
        self._told = set()

    @traced
    def ended(self):
        """The command has made its steps."""
        if self._has_started:
            _events.of_scene(self._root, "SimulationStopEvent")

    @traced
    def describe(self, file, session):
        from stroma import _stroma

        _stroma.prepare(session)

        self._root = self._given if self._given is not None else _scene_file.load(file)
        object.__setattr__(self._root, "_s_running", None)
        _engine.begin(self._root)
        self._mirror = Mirror(self._root)
        _engine.check(self._root)
        for each in self._root._s_all_objects() if self._words and self._words[0] == "migrate" else ():
            if not each._s_type or each._s_type in _catalogue.OF_PYTHON:
                _messages.warn(f"{each._s_place()}: {type(each).__name__} is written in Python, and not in the scene that is made")
        file = os.path.abspath(file)
        return _stroma.description(self._mirror.root._tuple(), file, _scene_file.own_files(file))

    @traced
    def loaded(self, session):
        import stroma
        from stroma import _stroma

        self._steps = 0
        self._running = _engine.Engine(self._root, stroma.Simulation(_stroma.adopt(session)), self._mirror)
        _engine.bind(self._root, self._running)

    @traced
    def before_step(self):
        steps = self._running.sim.steps
        if steps < self._steps:  # the view has gone back to the start
            self._running.gone_back()
        self._steps = steps
        if not self._has_started:
            self._has_started = True
            _events.of_scene(self._root, "SimulationStartEvent")
        self._part_of_step(self._running.begin_step)

    @traced
    def after_step(self):
        self._part_of_step(self._running.end_step)

    def _part_of_step(self, part):
        try:
            part(self._running.sim.dt)
        except _engine.TreeChanged:
            self.changes_tree = True
            if self._words and self._words[0] == "run" and "--record" not in self._words:  # no file has been begun
                run_again(self._words)
            raise

    @traced
    def key(self, name, pressed):
        character = Key.NAMED.get(name, name.upper() if len(name) == 1 else "")
        if character:
            _events.key(self._root, character, pressed)

    @traced
    def mouse(self, state, x, y, wheel):
        _events.mouse(self._root, state, x, y, wheel)

    # ---- errors ----
    @staticmethod
    def problems(error):
        """(file, line, sentence) of each, or None: the command says what is wrong as it does of any scene."""
        if isinstance(error, _scene_file.SceneFileError):
            return [(str(file), int(line or 0), str(text)) for file, line, text in error.problems]
        return None

    def tell_once(self, error, method):
        """An error in a force of the scene, which the engine asks for within a step. `method`: where the one that fails stands."""
        text = self.sentence(error, method)
        if text not in self._told:
            self._told.add(text)
            print(f"{text}: the force has no value", file=sys.stderr)

    @staticmethod
    def sentence(error, otherwise=None):
        place = _messages.place_of(error) or otherwise
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        if isinstance(error, SystemExit):
            text = f"the scene ends the run here: sys.exit({error.code})"
        return f"{place[0]}:{place[1]}: {text}" if place else text


def own_loop(words):
    """`run SCENE -n N` or `--until T` of a scene that changes its tree on the way: the engine is made anew then, which the command
    cannot do. In a process of its own: what modules of the scene remember is of the first attempt."""
    import argparse
    import json

    from . import Simulation

    parser = argparse.ArgumentParser(prog="stroma run", add_help=False)
    parser.add_argument("scene")
    parser.add_argument("-n", "--steps", type=int)
    parser.add_argument("--until", type=float)
    parser.add_argument("-q", "--quiet", action="store_true")
    parser.add_argument("--no-record", action="store_true")
    parser.add_argument("--record")
    parser.add_argument("--json")
    known, others = parser.parse_known_args(words)
    if others:
        print(f"{known.scene}: a scene that changes its tree while it runs is not run with {' '.join(others)}", file=sys.stderr)
        return 2
    if known.steps is None and known.until is None:
        known.steps = 100  # as the command
    print(f"note: {known.scene} changes its tree while it runs: it is run again, and nothing is recorded", file=sys.stderr)
    root = _scene_file.load(known.scene)
    Simulation.init(root)
    _events.of_scene(root, "SimulationStartEvent")
    while not ((known.steps is not None and root._s_running.steps >= known.steps) or (
            known.until is not None and root.getTime() >= known.until - 1e-9 * root.getDt())):
        Simulation.animate(root)
    _events.of_scene(root, "SimulationStopEvent")
    steps, time = root._s_running.steps, root.getTime()
    if not known.quiet and known.json != "-":
        print(f"{steps} steps, t = {time:.6g} s")
    if known.json:
        text = json.dumps({"scene": known.scene, "outcome": "done", "steps": steps, "simulated_time": time}, indent=2)
        if known.json == "-":
            print(text)
        else:
            with open(known.json, "w", encoding="utf-8") as file:
                file.write(text + "\n")
    return 0


def run_again(words):
    """In the place of this process."""
    sys.stdout.flush()
    sys.stderr.flush()
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})  # the command waits for it in a thread, which ends here
    os.execv(sys.executable, [sys.executable, "-m", "Sofa.command", "own-loop", *words[1:]])


def told(words, run):
    """What `run` returns; what it raises, as a sentence."""
    try:
        return run(words)
    except KeyboardInterrupt:
        return 130
    except Exception as error:
        print(error if Program.problems(error) else Program.sentence(error), file=sys.stderr)
        return 3


def main(words):
    from stroma import _command

    # nobody answers a scene that asks, and one that waits for another program waits for a while
    socket.setdefaulttimeout(float(os.environ.get("STROMA_SOCKET_SECONDS", 30)))
    if sys.stdin is None or not sys.stdin.isatty():
        sys.stdin = open(os.devnull, encoding="utf-8")
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(line_buffering=True)
    sys.argv = [next((word for word in words if word.endswith((".py", ".pyscn"))), "")]
    _engine._commanded.append(True)
    if words and words[0] == "own-loop":
        return told(list(words[1:]), own_loop)
    program = Program(words=list(words))
    _force_field.tells.append(program.tell_once)
    code = _command.main(list(words), program)
    if program.changes_tree and words[0] == "run":
        run_again(words)
    return told(words, lambda _: program.ended() or code)


def end(code):
    """The end of the process: files of the scene are whole, and threads and processes that it has left running do not keep the
    command."""
    if "multiprocessing" in sys.modules:  # whose exit function would wait for them
        for child in sys.modules["multiprocessing"].active_children():
            child.kill()
    atexit._run_exitfuncs()
    for each in gc.get_objects():
        if isinstance(each, io.IOBase) and not each.closed:
            try:
                each.flush()
            except (OSError, ValueError):  # read only, or its reader has gone
                pass
    os._exit(code)


if __name__ == "__main__":
    end(main(sys.argv[1:]))
