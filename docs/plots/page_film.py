#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes an animated GIF, or one picture, of a page that `stroma view --export` has written.

  page_film.py organ.html --out organ.gif
  page_film.py organ.html --out organ.gif --from 1 --to 3 --speed 0.5 --width 520 --height 300
  page_film.py organ.html --out organ.png --at 1.5

docs/organ.gif is made by
  build/release/bin/stroma view scenes/examples/organ_pulled.xml --export organ.html -n 350 --every 4 --field vonMises
  docs/plots/page_film.py organ.html --out docs/organ.gif --from 1.15 \
      --view '{"held": false, "range": "fixed", "low": 0, "high": 1500}'

The page is drawn by Chromium without a screen, as anybody sees it. Needs Debian's chromium, chromium-driver, python3-selenium and
Pillow (python3-pil).
"""
import argparse
import io
import json
import os
import sys
import tempfile
import time

from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

PANELS = "#bar, #left, #right, #foot { display: none !important } #app { display: block !important } " \
         "#middle, #picture { position: fixed !important; inset: 0 !important; width: 100vw; height: 100vh }"


def browser(folder, width, height):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in ("--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                     "--no-sandbox", "--hide-scrollbars", f"--user-data-dir={folder}", f"--window-size={width},{height}"):
        options.add_argument(argument)
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def open_page(driver, path, width, height):
    driver.get("file://" + os.path.abspath(path))
    # the window is larger than what it shows
    inner = driver.execute_script("return [innerWidth, innerHeight]")
    driver.set_window_size(2 * width - inner[0], 2 * height - inner[1])
    until = time.monotonic() + 30
    while not driver.execute_script("return Boolean(window.stroma && window.stroma.ready)"):
        if time.monotonic() > until:
            sys.exit(f"{path}: the page does not start (expected one that stroma view --export has written)")
        time.sleep(0.05)
    driver.execute_script("const style = document.createElement('style'); style.textContent = arguments[0];"
                          "document.head.append(style); window.dispatchEvent(new Event('resize'));"
                          "if (stroma.timeline.playing) stroma.timeline.toggle(); stroma.store.setView({theme: 'light'});", PANELS)
    time.sleep(0.5)
    driver.execute_script("stroma.stage.fit()")


def picture(driver, index):
    """Of the frame with this number, when it has been drawn."""
    driver.set_script_timeout(20)
    driver.execute_async_script("const done = arguments[1]; stroma.timeline.seek(arguments[0]);"
                                "requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))", index)
    return Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", help="a page that stroma view --export has written")
    parser.add_argument("--out", required=True, help="file to write: .gif or .png")
    parser.add_argument("--from", dest="start", type=float, default=float("-inf"), help="first time [s]")
    parser.add_argument("--to", dest="end", type=float, default=float("inf"), help="last time [s]")
    parser.add_argument("--at", type=float, help="time of a single picture [s]")
    parser.add_argument("--speed", type=float, default=1, help="of the film; 1: that of the simulated time")
    parser.add_argument("--width", type=int, default=520)
    parser.add_argument("--height", type=int, default=300)
    parser.add_argument("--view", type=json.loads, default={}, help="choices of the page as JSON: colour, map, range, low, high, "
                        "exaggeration, wireframe, held, cut, theme ...")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        driver = browser(folder, arguments.width, arguments.height)
        try:
            open_page(driver, arguments.page, arguments.width, arguments.height)
            driver.execute_script("stroma.store.setView(arguments[0])", arguments.view)
            times = driver.execute_script("return stroma.history.frames.map(frame => frame.header.time)")
            if arguments.at is not None:
                picture(driver, min(range(len(times)), key=lambda i: abs(times[i] - arguments.at))).save(arguments.out)
                return
            chosen = [i for i, t in enumerate(times) if arguments.start - 1e-9 <= t <= arguments.end + 1e-9]
            if len(chosen) < 2:
                sys.exit(f"{arguments.page}: {len(chosen)} frames between t = {arguments.start:g} and {arguments.end:g} s; a film needs two")
            for i in range(len(times)):  # the range of the legend is that of the whole run
                picture(driver, i) if i % 8 == 0 or i + 1 == len(times) else None
            pictures = [picture(driver, i) for i in chosen]
        finally:
            driver.quit()
    palette = pictures[len(pictures) // 2].quantize(128)
    frames = [each.quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures]
    step = 1e3 * (times[chosen[1]] - times[chosen[0]]) / arguments.speed
    frames[0].save(arguments.out, save_all=True, append_images=frames[1:], duration=max(20, round(step / 10) * 10), loop=0, optimize=True)
    print(f"{arguments.out}: {len(frames)} frames, t = {times[chosen[0]]:g} to {times[chosen[-1]]:g} s")


if __name__ == "__main__":
    main()
