# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""study_page.py CHROMIUM CHROMEDRIVER REAMSIM ASSETS: opens sweep.html of a study in a headless Chromium: of a real one
whose runs keep their reports, and of one with 10,000 runs that this test writes. Sorts, filters, chooses columns, opens
runs and reports; compares what the page computes with runs.csv and effects.csv; keyboard, screen reader, 400 px.

study_page.py CHROMIUM CHROMEDRIVER PAGE.html...: prints the size of pages and the time until they are ready."""

import csv
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from report_access import check_rules
from report_page import Browser, check_loads_alone, check_names, check_width

MOST_BYTES = 15_000_000
WIDE_PX = 1000
SMALL = """version: 1
base: base.yaml
vary:
  - motion.plunge.depth_mm: [0.5, 1, deep]
  - motion.plunge.feed_mm_s: [4, 5]
keep: [summary, pictures]
"""
BASE = """version: 2
bone: {source: phantom, voxel_mm: 0.5, phantom: {shape: half_space, size_mm: [10, 10, 6]}}
tool: {mesh: %s/reamer_flat.stl}
motion: {frame_rate_hz: 100, plunge: {entry_mm: [0, 0, 0], axis: [0, 0, -1], approach_mm: 0.5, feed_mm_s: 5, depth_mm: 1, retract_mm: 2}}
engine: {device: serial}
render: {width_px: 160, height_px: 120}
"""
LARGE = """version: 1
base: base.yaml
vary:
  - motion.plunge.depth_mm: [0.5, 1]
  - motion.plunge.feed_mm_s: [4, 5]
sample: {n: 2500, of: {cutting.normal_ratio: {uniform: [0.3, 0.7]}, cutting.specific_energy_j_mm3: {lognormal: [0.15, 0.3]}}}
"""


class Page:
    def __init__(self, driver, path):
        self.driver = driver
        driver.get(path.resolve().as_uri())
        WebDriverWait(driver, 60).until(lambda d: d.execute_script("return document.documentElement.dataset.readyMs"))
        self.ready_ms = int(driver.execute_script("return document.documentElement.dataset.readyMs"))

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def press(self, selector):
        element = self.find(selector)
        self.click(element)
        self.wait()

    def click(self, element):
        self.script("arguments[0].scrollIntoView({block: 'center', inline: 'center', behavior: 'instant'})", element)
        element.click()

    def wait(self):
        """The page filters soon after the last change."""
        self.driver.execute_async_script("setTimeout(() => requestAnimationFrame(arguments[0]), 120)")

    def type(self, selector, text):
        field = self.find(selector)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text if text else Keys.DELETE)
        self.wait()

    def choose(self, selector, value):
        self.script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", self.find(selector), value)
        self.wait()

    def shown(self):
        return self.find("#shown").text.replace("\u2009", "")

    def column(self, title):
        """The cells in sight of the column with this title."""
        return self.script("""
          const i = [...document.querySelectorAll('#table thead th')].findIndex((th) => th.textContent === arguments[0]);
          return i < 0 ? null : [...document.querySelectorAll('#table tbody tr:not(.space)')].map((row) => row.cells[i].textContent);""", title)

    def sort(self, title):
        head = [button for button in self.all("#table thead button") if button.text.replace("\n", " ") == title]
        assert len(head) == 1, f"{title} in {[button.text for button in self.all('#table thead button')]}"
        self.click(head[0])
        return self.script("return arguments[0].parentElement.getAttribute('aria-sort')", head[0])


def rows_of(folder, name="runs.csv"):
    with open(folder / name, newline="") as file:
        return list(csv.DictReader(file))


def check_filters(page, rows):
    assert page.shown() == f"{len(rows)} of {len(rows)} runs shown", page.shown()
    failed = [row for row in rows if row["status"] == "failed"]
    page.type("#search", "failed")
    assert page.shown() == f"{len(failed)} of {len(rows)} runs shown", page.shown()
    assert set(page.column("Status")) == {"failed"}
    assert failed[0]["message"] in page.column("Message")
    page.type("#search", "")
    page.press("#states label:nth-of-type(2) input")
    assert page.shown().startswith(f"{len(rows) - len(failed)} of"), "the check box of a status hides it"
    page.press("#parameter-filters fieldset:nth-of-type(2) label:nth-of-type(1) input")
    left = [row for row in rows if row["status"] != "failed" and row["motion.plunge.feed_mm_s"] != "4"]
    assert page.shown().startswith(f"{len(left)} of"), page.shown()
    page.choose("#add-range", "removed_mm3")
    middle = sorted(float(row["removed_mm3"]) for row in left)[len(left) // 2] - 1e-3
    page.type("#ranges input[aria-label$='from']", str(middle))
    left = [row for row in left if float(row["removed_mm3"]) >= middle]
    assert page.shown().startswith(f"{len(left)} of"), page.shown()
    page.press("#reset")
    assert page.shown() == f"{len(rows)} of {len(rows)} runs shown", page.shown()


def check_sorting(page, rows):
    title = "Removed volume, mm³"
    values = sorted(float(row["removed_mm3"]) for row in rows if row["removed_mm3"])
    number = lambda text: float(text.replace("\u2009", ""))
    assert page.sort(title) == "ascending"
    assert abs(number(page.column(title)[0]) / values[0] - 1) < 1e-4
    assert page.sort(title) == "descending"
    assert abs(number(page.column(title)[0]) / values[-1] - 1) < 1e-4
    page.script("document.getElementById('rows').scrollTop = 1e9")
    page.wait()
    if len(values) < len(rows):
        assert page.column(title)[-1] == "–", "missing values come last"
    assert page.sort(title) is None, "the third click restores the order of the plan"
    page.script("document.getElementById('rows').scrollTop = 0")
    page.wait()
    assert page.column("Run")[0] == "1"


def check_columns(page):
    assert page.column("Balance") is None
    page.press("#columns summary")
    page.type("#column-search", "balance")
    boxes = [label for label in page.all("#column-list label") if label.is_displayed()]
    assert len(boxes) == 1, [label.text for label in boxes]
    page.click(boxes[0])
    page.wait()
    assert page.column("Balance") is not None
    page.type("#column-search", "")
    page.press("#columns summary")


def check_effects(page, folder):
    """What the page explains is what effects.csv has: two programs compute it."""
    compared = 0
    for row in rows_of(folder, "effects.csv"):
        got = page.script("""
          const { study, effects } = window.study, runs = Uint32Array.from(study.states.keys()).filter((run) => study.stateText(run) === 'done');
          const effect = effects.ranked(study.byKey.get(arguments[1]), runs).find((e) => e.parameter.key === arguments[0]);
          return [effect.explained, effect.sums.map((s) => s.mean)];""", row["parameter"], row["result"])
        assert abs(got[0] - float(row["explained"])) < 1e-4, f"{row}: {got}"
        assert min(abs(mean - float(row["mean"])) for mean in got[1]) < 1e-4 * abs(float(row["mean"])) + 1e-6, f"{row}: {got}"
        compared += 1
    assert compared > 5
    panels = page.all("#effect-panels svg")
    assert panels and all("explains" in panel.get_attribute("aria-label") for panel in panels)
    print(f"{compared} means and fractions agree with effects.csv")


def check_scatter(page):
    canvas = page.find("#scatter-canvas")
    page.choose("#scatter-x", "removed_mm3")
    assert "Removed volume" in canvas.get_attribute("aria-label")
    pixels = lambda: page.script("return arguments[0].getContext('2d').getImageData(0, 0, arguments[0].width, arguments[0].height).data.filter((v, i) => i % 4 === 3 && v > 0).length", canvas)
    assert pixels() > 500, "the plot is empty"
    canvas.send_keys(Keys.ARROW_RIGHT)
    first = page.find("#scatter-run").text
    canvas.send_keys(Keys.ARROW_RIGHT)
    assert first.startswith("Run ") and page.find("#scatter-run").text != first
    canvas.send_keys(Keys.ENTER)
    assert page.find("#run-dialog").is_displayed()
    page.press("#run-close")


def check_keyboard(page):
    """Tab reaches every control, and each shows that it has the focus; arrow keys move from run to run."""
    controls = page.script("""
      window.controls = [...document.querySelectorAll('a[href], button, select, input, canvas, summary, [tabindex="0"]')].filter((e) =>
        e.getClientRects().length > 0 && !e.closest('dialog') && !e.closest('details:not([open]) > :not(summary)'));
      window.reached = new Set();
      document.activeElement.blur();
      scrollTo(0, 0);
      return controls.length;""")
    page.find("body").send_keys(Keys.TAB)
    for _ in range(controls + 60):  # rows that come into sight are reached too
        page.script("""
          const e = document.activeElement, style = getComputedStyle(e);
          if (style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 1) reached.add(e.dataset.run ?? e);""")
        page.driver.switch_to.active_element.send_keys(Keys.TAB)
    missed = page.script("return controls.filter((e) => !reached.has(e.dataset.run ?? e)).map((e) => e.outerHTML.slice(0, 100))")
    assert not missed, f"Tab does not reach {missed}, or does not show it"
    page.script("document.querySelector('#table tbody button').focus()")
    page.driver.switch_to.active_element.send_keys(Keys.ARROW_DOWN, Keys.ARROW_DOWN)
    assert page.driver.switch_to.active_element.get_attribute("aria-label") == "Run 3"
    page.driver.switch_to.active_element.send_keys(Keys.ENTER)
    assert page.find("#run-title").text.startswith("Run 3,")
    page.driver.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not page.find("#run-dialog").is_displayed()


def check_small(page, folder):
    rows = rows_of(folder)
    assert [row["status"] for row in rows] == ["done"] * 4 + ["failed"] * 2
    assert "2 of 6 runs failed" in page.find("#failures").text
    message = rows[4]["message"].removeprefix("'")  # so that a spreadsheet takes it for a text
    assert message in page.find("#failures").text, f"{message!r} in {page.find('#failures').text!r}"
    warned = [row["message"] for row in rows if row["status"] == "done" and row["message"]]
    assert page.find("#warned").is_displayed() == (len(warned) > 0) and all(text in page.find("#warned").text for text in warned)
    links = [link.get_attribute("href") for link in page.all("#table tbody a")]
    assert len(links) == 4 and all((folder / "runs" / row["id"] / "report.html").resolve().as_uri() in links for row in rows[:4]), links
    page.click(page.find("#table tbody a"))
    WebDriverWait(page.driver, 20).until(lambda d: "reaming report" in d.title)
    page.driver.back()
    WebDriverWait(page.driver, 20).until(lambda d: d.execute_script("return document.documentElement.dataset.readyMs"))


def write_large(program, folder):
    """A study of 10,000 runs, of which some failed, with results of a formula: as `sweep run` leaves them."""
    (folder / "large.yaml").write_text(LARGE)
    study = folder / "large"
    for part in ("runs", "failed"):
        (study / part).mkdir(parents=True)
    (study / "study.json").write_text(json.dumps({"kind": "study", "study": "large"}))
    subprocess.run([program, "sweep", "collect", folder / "large.yaml", "-o", study], check=True, capture_output=True)
    random.seed(1)
    for row in rows_of(study):
        if int(row["run"]) % 500 == 7:
            (study / "failed" / f"{row['id']}.json").write_text(json.dumps({"message": "the device is lost"}))
            continue
        depth, feed, u = (float(row[key]) for key in ("motion.plunge.depth_mm", "motion.plunge.feed_mm_s", "cutting.specific_energy_j_mm3"))
        force = 50 * depth * u / 0.15 * float(row["cutting.normal_ratio"]) * feed
        summary = {"headline": {"peak_axial_force_n": force, "peak_spin_torque_nmm": 12 * depth * u * feed},
                   "removed_mm3": 80 * depth + random.gauss(0, 5), "balance": random.gauss(0, 1e-6),
                   "warnings": ["removed 2 mm3 in frame 0, without force"] if int(row["run"]) % 1000 == 9 else [],
                   "more": {f"number_{i}_mm": random.random() for i in range(100)}}
        run = study / "runs" / row["id"]
        run.mkdir()
        (run / "summary.json").write_text(json.dumps(summary))
        (run / "scenario.yaml").write_text("version: 2\n")
        (run / "manifest.json").write_text(json.dumps({"kind": "run", "files": ["scenario.yaml", "summary.json"]}))
    start = time.monotonic()
    subprocess.run([program, "sweep", "collect", folder / "large.yaml", "-o", study], check=True, capture_output=True)
    print(f"10,000 runs collected in {time.monotonic() - start:.1f} s")
    return study


def check_rows_in_sight(page):
    """Of 10,000 rows some fifty are in the document, wherever one scrolls."""
    most = 0
    for place in (0, 0.3, 0.77, 1):
        page.script("const e = document.getElementById('rows'); e.scrollTop = arguments[0] * e.scrollHeight", place)
        page.wait()
        rows = page.column("Run")
        most = max(most, len(rows))
        expected = place * 10_000
        assert min(abs(int(number) - expected) for number in rows) <= 60, f"{place}: {rows[:3]}"
    assert most < 80, f"{most} rows"
    assert page.find("#table").get_attribute("aria-rowcount") == "10001"
    page.script("document.getElementById('rows').scrollTop = 0")
    page.wait()
    sorted_ms = page.script("""
      const start = performance.now();
      [...document.querySelectorAll('#table thead button')].at(-1).click();
      return performance.now() - start;""")
    page.wait()
    page.sort("Run")
    print(f"10,000 runs sorted in {sorted_ms:.0f} ms")
    assert sorted_ms < 2000


def open_page(programs, folder, path, width, height, use):
    browser = Browser(programs, folder, width, height)
    try:
        browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                       {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        page = Page(browser.driver, path)
        print(f"{path.parent.name}: {path.stat().st_size} bytes, ready after {page.ready_ms} ms at {width} px")
        assert page.ready_ms < 20_000
        check_width(page, width)
        check_names(page)
        check_rules(page)
        use(page)
        check_rules(page)
        check_loads_alone(browser.driver, path)
    finally:
        browser.close()


def use_small(folder):
    def use(page):
        check_small(page, folder)
        check_keyboard(page)
        page.script("document.querySelector('#table tbody button').click()")
        check_rules(page)
        page.press("#run-close")
    return use


def use_large(folder, width):
    rows = rows_of(folder)

    def use(page):
        check_rows_in_sight(page)
        assert "10 of 10000 runs are done and have warnings" in page.find("#warned").text, page.find("#warned").text
        assert " and 9 more: removed 2 mm3 in frame 0, without force" in page.find("#warned").text
        if width < WIDE_PX:
            return  # what is shown and computed does not depend on the window
        check_filters(page, rows)
        check_sorting(page, rows)
        check_columns(page)
        check_effects(page, folder)
        check_scatter(page)
    return use


def main():
    if sys.argv[3].endswith(".html"):
        for path in map(pathlib.Path, sys.argv[3:]):
            with tempfile.TemporaryDirectory() as folder:
                open_page(sys.argv[1:3], pathlib.Path(folder), path, 1280, 900, lambda page: None)
        return
    *programs, program, assets = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "base.yaml").write_text(BASE % assets)
        (folder / "small.yaml").write_text(SMALL)
        done = subprocess.run([program, "sweep", "run", folder / "small.yaml", "-o", folder / "small"], capture_output=True, text=True)
        assert done.returncode == 1 and "2 runs failed" in done.stderr, done.stderr
        large = write_large(program, folder)
        for study in (folder / "small", large):
            assert (study / "sweep.html").stat().st_size < MOST_BYTES
        for width, height in ((1280, 900), (400, 800)):
            open_page(programs, folder / f"s{width}", folder / "small/sweep.html", width, height, use_small(folder / "small"))
            open_page(programs, folder / f"l{width}", large / "sweep.html", width, height, use_large(large, width))


if __name__ == "__main__":
    main()
