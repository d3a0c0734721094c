# SPDX-License-Identifier: LGPL-2.1-or-later
"""Chromium without a window, and what tests ask of the page of `stroma view`."""
import base64
import io
import os
import shutil
import socket
import sys
import tempfile
import threading
import time

try:
    import numpy
    from PIL import Image
    from selenium import webdriver
    from selenium.common.exceptions import JavascriptException, StaleElementReferenceException, WebDriverException
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.chrome.service import Service
except ImportError as missing:
    print(f"skipped: {missing} (packages python3-selenium, python3-numpy and python3-matplotlib)")
    sys.exit(77)

from websocket import PATIENCE  # pylint: disable=wrong-import-position

ATTEMPTS = 3  # to start the browser: its port may be taken meanwhile, and it gives up by itself where it is not given time


def skip_without_browser():
    """Ends the program with 77 and a reason."""
    for program, package in (("chromium", "chromium"), ("chromedriver", "chromium-driver")):
        if not shutil.which(program):
            print(f"skipped: there is no {program} (package {package})")
            sys.exit(77)


def difference(one, other):
    """The part of the numbers of two pictures that differ: all, where their sizes do."""
    return (one != other).mean() if one.shape == other.shape else 1


class Browser:
    """One browser for all cases; a context."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="stroma_browser_")
        self.downloads = os.path.join(self.folder, "downloads")
        os.mkdir(self.downloads)
        self.driver = self.started()
        self.driver.set_page_load_timeout(PATIENCE)
        self.driver.set_script_timeout(PATIENCE)
        self.size()

    def started(self):
        """A driver."""
        for attempt in range(1, ATTEMPTS + 1):
            service = Service(shutil.which("chromedriver"))
            try:
                return webdriver.Chrome(options=self.options(f"profile{attempt}"), service=service)
            except WebDriverException as error:
                if getattr(service, "process", None):
                    service.stop()
                if attempt == ATTEMPTS:
                    raise
                print(f"the browser did not start, and is started again: {error}", flush=True)

    def options(self, profile):
        """How it is started."""
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for argument in ("--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox",
                         "--disable-gpu-compositing", "--disable-gpu-rasterization",  # by software too, and not by way of another imitated card
                         # however slow the machine is, nothing is given up and nothing waits for a page that nobody looks at
                         "--disable-gpu-watchdog", "--disable-hang-monitor", "--disable-renderer-backgrounding",
                         "--disable-backgrounding-occluded-windows", "--disable-background-timer-throttling",
                         "--disable-dev-shm-usage", "--disable-extensions", "--no-first-run", "--disable-background-networking",
                         "--disable-component-update", "--disable-sync", "--mute-audio", "--window-size=1280,800", "--force-device-scale-factor=1",
                         f"--user-data-dir={os.path.join(self.folder, profile)}"):
            options.add_argument(argument)
        options.add_experimental_option("prefs", {"download.default_directory": self.downloads, "download.prompt_for_download": False,
                                                  "profile.default_content_setting_values.automatic_downloads": 1})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        return options

    def close(self):
        """Ends the browser."""
        self.driver.quit()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def size(self, width=800, height=500, touch=False):
        """Of the page, in CSS pixels: each is drawn by software; with `touch`, a device without a mouse."""
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": touch})
        self.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": touch, "maxTouchPoints": 5 if touch else 1})

    def scheme(self, name):
        """light or dark, as the system would ask for."""
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": name}]})

    def script(self, text, *arguments):
        """The value of some JavaScript."""
        return self.driver.execute_script("return " + text, *arguments)

    def open(self, address, ready=True):
        """An address, and waits until the scene is drawn."""
        self.driver.get(address)
        if ready:
            self.until("window.stroma && window.stroma.ready && window.stroma.store.bodies.length > 0", "the scene to be drawn")

    def leave(self):
        """Replaces the page by an empty one and waits until it is gone: a server that ends earlier would be missed, rightly."""
        if self.script("location.href !== 'about:blank'"):
            self.driver.get("about:blank")
            self.until("location.href === 'about:blank' && !window.stroma", "the page to be left")

    def holds(self, condition):
        """Whether a condition is true: a function, or some JavaScript, for which the page itself waits up to a quarter of a second.
        A question from outside wakes four processes in turn; beside other programs each of them first waits for a core."""
        if callable(condition):
            return condition()
        value, problem = self.driver.execute_async_script(
            "const answer = arguments[0], end = performance.now() + 250; (function ask() { let value = false, problem = null;"
            f" try {{ value = !!({condition}); }} catch (error) {{ problem = String(error); }}"
            " if (value || performance.now() > end) answer([value, problem]); else setTimeout(ask, 4); })();")
        if problem:
            raise JavascriptException(problem)
        return value

    def until(self, condition, what, seconds=PATIENCE):
        """Waits for some JavaScript, or a function, to be true. What it asks about may not be there yet, or be made again meanwhile."""
        end, problem, pause = time.monotonic() + seconds, "", 0.002
        while True:
            try:
                value = self.holds(condition)
                if value:
                    return value
            except (JavascriptException, StaleElementReferenceException) as error:
                problem = str(error)
            if time.monotonic() > end:
                raise AssertionError(f"waited {seconds} s for {what}\n{problem}\n" + "\n".join(self.complaints()))
            time.sleep(pause)
            pause = min(2 * pause, 0.03)  # most have not long to wait

    def complaints(self):
        """What the console holds of errors and warnings since it was last asked; but not that drawing is done by software."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] in ("SEVERE", "WARNING") and "GPU stall" not in entry["message"] and "swiftshader" not in entry["message"].lower()]

    # ---- elements ----

    def find(self, name):
        """By data-test."""
        return self.driver.find_element(By.CSS_SELECTOR, f'[data-test="{name}"]')

    def css(self, selector):
        """By any selector."""
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def click(self, name):
        """What has this data-test."""
        self.find(name).click()

    def press(self, *keys):
        """On the page."""
        ActionChains(self.driver).send_keys(*keys).perform()

    def press_with(self, modifier, key):
        """A key while another one is down."""
        ActionChains(self.driver).key_down(modifier).send_keys(key).key_up(modifier).perform()

    def key(self, key, **more):
        """An event of a key that an own keyboard could not make, such as Caps Lock."""
        self.script("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0], bubbles: true, cancelable: true, ...arguments[1]}))", key, more)

    def drawn_step(self, step):
        """Waits until the picture of a step is drawn."""
        self.until(f"window.stroma.store.shown.header.step === {step} && window.stroma.frameDrawn === window.stroma.store.shown.header.frame", f"the picture of step {step}")

    def choose(self, name, value):
        """In a list."""
        self.script("(() => { const e = arguments[0]; e.value = arguments[1]; e.dispatchEvent(new Event('change', {bubbles: true})); })()",
                    self.find(name), value)

    # ---- pictures ----

    def picture(self, element="canvas"):
        """Pixels of an element, (height, width, 3), as they are shown."""
        *box, across, down, x, y = self.script("(r => [r.left, r.top, r.width, r.height, innerWidth, innerHeight, scrollX, scrollY])"
                                               "(document.querySelector(arguments[0]).getBoundingClientRect())", element)
        left, top, width, height = (int(round(value)) for value in box)
        right, bottom, left, top = min(left + width, across), min(top + height, down), max(0, left), max(0, top)
        # of this part alone, and packed less tightly: it costs half of what a picture of all does
        coded = self.driver.execute_cdp_cmd("Page.captureScreenshot", {
            "format": "png", "optimizeForSpeed": True,
            "clip": {"x": left + x, "y": top + y, "width": right - left, "height": bottom - top, "scale": 1}})["data"]
        return numpy.asarray(Image.open(io.BytesIO(base64.b64decode(coded))).convert("RGB"))

    def still(self, element="canvas"):
        """The picture of a run that is paused, when nothing is left to draw: two in a row are alike."""
        seen = []

        def alike():
            self.until("!window.stroma.stage.asked && window.stroma.frameDrawn === (window.stroma.store.shown?.header.frame ?? -1)", "the drawing to end")
            seen.append(self.picture(element))
            return len(seen) > 1 and difference(*seen[-2:]) == 0
        self.until(alike, "a still picture")
        return seen[-1]

    def drawn(self):
        """Part of the picture that is not its most frequent colour, and how many colours that part has."""
        pixels = self.picture().reshape(-1, 3)
        codes = pixels.astype(int) @ [65536, 256, 1]
        colours, counts = numpy.unique(codes, return_counts=True)
        background = colours[counts.argmax()]
        return (codes != background).mean(), len(colours) - 1

    def positions(self, body=0):
        """As last drawn."""
        return numpy.array(self.script(f"Array.from(window.stroma.positions({body}))")).reshape(-1, 3)

    def reachable(self, score="0"):
        """(node, x, y) of the node of body 0 with the highest score (an expression of its rest position r) that is picked at its
        own pixel; pixels are whole numbers, as those of a mouse."""
        found = self.script("""(() => { const s = window.stroma, b = s.store.bodies[0]; let best = [-Infinity, null];
            for (let n = 0; n < b.surface; ++n) {
              const p = s.screenOf(0, n), x = Math.round(p.x), y = Math.round(p.y), r = b.rest.subarray(3 * n, 3 * n + 3);
              const score = """ + score + """;
              if (score > best[0] && document.elementFromPoint(x, y) === s.stage.canvas && s.pick(x, y)?.node === n) best = [score, [n, x, y]];
            } return best[1]; })()""")
        assert found, "no node is picked at its own pixel"
        return found

    # ---- hands ----

    def pointer(self, kind, x, y, touch=False):
        """down, move or up, as the browser's own input."""
        if touch:
            points = [] if kind == "up" else [{"x": x, "y": y}]
            names = {"down": "touchStart", "move": "touchMove", "up": "touchEnd"}
            self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": names[kind], "touchPoints": points})
            return
        names = {"down": "mousePressed", "move": "mouseMoved", "up": "mouseReleased"}
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": names[kind], "x": x, "y": y, "clickCount": 0 if kind == "move" else 1,
                                                                 "button": "left", "buttons": 0 if kind == "up" else 1})

    def download(self, click, ending, seconds=PATIENCE):
        """What a click writes; the bytes of a whole file with this ending."""
        before = set(os.listdir(self.downloads))
        click()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            names = os.listdir(self.downloads)
            new = [os.path.join(self.downloads, name) for name in set(names) - before if name.endswith(ending)]
            # The name is taken by an empty file first; what comes is written under another one, which is the file at the end.
            if new and os.path.getsize(new[0]) > 0 and not any(name.endswith(".crdownload") for name in names):
                with open(new[0], "rb") as file:
                    return new[0], file.read()
            time.sleep(0.05)
        raise AssertionError(f"no file *{ending} was written; the console: {self.complaints()}")


class Proxy:
    """Stands between the page and the server; can cut what goes through it."""

    def __init__(self, port):
        self.target, self.is_cut, self.pairs, self.lock = port, False, [], threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                near, _ = self.listener.accept()
            except OSError:
                return
            with self.lock:  # no connection is made while all are cut
                if self.is_cut:
                    near.close()
                    continue
                far = socket.create_connection(("127.0.0.1", self.target))
                self.pairs += [near, far]
            for one, other in ((near, far), (far, near)):
                threading.Thread(target=self._pump, args=(one, other), daemon=True).start()

    def _pump(self, source, target):
        try:
            while data := source.recv(1 << 16):
                if data[:4] == b"GET ":  # the server knows its own name alone
                    data = data.replace(f"127.0.0.1:{self.port}".encode(), f"127.0.0.1:{self.target}".encode())
                target.sendall(data)
        except OSError:
            pass
        for one in (source, target):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def cut(self):
        """From now on nothing goes through."""
        with self.lock:
            self.is_cut, pairs, self.pairs = True, self.pairs, []
        for one in pairs:
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # the other end was first
            one.close()

    def mend(self):
        """New connections go through."""
        self.is_cut = False

    def close(self):
        """For good."""
        self.listener.close()
        self.cut()


__all__ = ["Browser", "Image", "Keys", "Proxy", "difference", "skip_without_browser"]
