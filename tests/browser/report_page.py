# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""report_page.py CHROMIUM CHROMEDRIVER RESULTS: opens RESULTS/report.html in a headless Chromium and uses it as a reader would."""

import csv
import io
import json
import pathlib
import sys
import tempfile
import time

from PIL import Image, ImageChops
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

import report_access
from chromium import Browser

MOST_BYTES = 15_000_000


class Page:
    def __init__(self, driver, path):
        self.driver = driver
        driver.get(path.resolve().as_uri())
        WebDriverWait(driver, 60).until(lambda d: d.find_element(By.CSS_SELECTOR, "#bone-axes line"))

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def set_slider(self, selector, value):
        self.driver.execute_script(
            "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input'));", self.find(selector), value)

    def data(self):
        """What the page holds for its scripts, without the large parts."""
        return json.loads(self.driver.execute_script("""
          const {plot, bone, tool, pictures} = JSON.parse(document.getElementById('page-data').textContent);
          return JSON.stringify({frame: plot.frame, look: bone.look, triangles: tool.passes[0].mesh.triangles, removed: plot.removed_mm3});"""))

    def numbers(self, name):
        """Numbers in a data attribute of the 3D view."""
        return [float(number) for number in self.find("#bone-canvas").get_attribute(f"data-{name}").split()]

    def bone(self):
        """The 3D view as it stands on the screen."""
        self.driver.execute_script("document.querySelector('.stage').scrollIntoView({behavior: 'instant'})")
        # Drawn with the next picture of the screen.
        self.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        time.sleep(0.1)
        return Image.open(io.BytesIO(self.find("#bone-canvas").screenshot_as_png)).convert("RGB")

    def pictured_frame(self):
        return int(self.find("#frame-picture").get_attribute("data-frame"))

    def click(self, element):
        """In the middle of the window, where the bar of the time slider does not cover it."""
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", element)
        element.click()

    def choose(self, name, value):
        self.click(self.find(f"input[name={name}][value={value}]"))


def changed_fraction(before, after):
    """Share of pixels that differ by more than a shade."""
    gray = ImageChops.difference(before, after).convert("L").point(lambda p: 255 if p > 12 else 0)
    return gray.histogram()[255] / (gray.width * gray.height)


def check_loads_alone(driver, path):
    """No error, and nothing but the file itself was asked for."""
    complaints = [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
    assert not complaints, complaints
    own = path.resolve().as_uri()
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    requests = [m["params"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    # The browser's own start page asks for its parts as well.
    asked = [r["request"]["url"] for r in requests if r["documentURL"] == own]
    assert own in asked, "the log of requests is empty"
    strange = [url[:100] for url in asked if not url.startswith(("data:", "blob:")) and url != own]
    assert not strange, f"the page asks for {strange[:5]}"


def check_cursor(page):
    last = int(page.find("#time").get_attribute("max"))
    page.set_slider("#time", 0)
    first_frame, first_picture = page.pictured_frame(), page.find("#frame-picture").get_attribute("src")
    page.set_slider("#time", last)
    assert page.pictured_frame() > first_frame, "the slider does not move the picture"
    assert page.find("#frame-picture").get_attribute("src") != first_picture
    cursors = page.driver.find_elements(By.CSS_SELECTOR, "#plots .u-cursor-x")
    assert len(cursors) == 4
    if page.find("#plot-ranges").is_displayed():
        page.choose("range", "whole")
    plot = page.find("#plots .u-over")
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", plot)
    webdriver.ActionChains(page.driver).move_to_element_with_offset(plot, -plot.size["width"] // 2 + 3, 0).perform()
    assert page.pictured_frame() == first_frame, "pointing at the curve's start does not show the first picture"
    places = {cursor.get_attribute("style").split("translate(")[1].split("px")[0] for cursor in cursors}
    assert len(places) == 1, f"the cursors of the panels stand at {places}"
    slider = page.find("#time")
    before = slider.get_attribute("value")
    slider.send_keys(Keys.ARROW_RIGHT)
    assert int(slider.get_attribute("value")) == int(before) + 1, "the arrow keys do not move the cursor"
    assert page.find("#time-value").text.endswith(" s")


def check_bone(page):
    page.choose("state", "after")
    after = page.bone()
    warm = sum(red > blue + 20 for red, green, blue in after.getdata()) / (after.width * after.height)
    assert warm > 0.1, f"only {warm:.1%} of the 3D view look like bone"
    page.choose("state", "before")
    assert changed_fraction(after, page.bone()) > 0.01, "before and after look the same"
    page.choose("state", "after")
    assert changed_fraction(after, page.bone()) < 0.001, "the view does not come back"
    page.choose("surface", "plain")
    assert changed_fraction(after, page.bone()) > 0.01, "depth colours make no difference"
    page.choose("surface", "depth")
    Select(page.find("#cut-plane")).select_by_index(1)
    middle = page.bone()
    assert changed_fraction(after, middle) > 0.02, "the section cuts nothing"
    page.set_slider("#cut-offset", -4)
    assert changed_fraction(middle, page.bone()) > 0.01, "the section's slider moves nothing"
    Select(page.find("#cut-plane")).select_by_index(0)
    page.click(page.find("#bone-views button"))  # the view of the beginning; the section has turned it
    assert changed_fraction(after, page.bone()) < 0.001, "the section does not close again"
    page.find("#bone-canvas").send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert changed_fraction(after, page.bone()) > 0.01, "arrow keys do not turn the bone"


def near(found, expected, most):
    return max(abs(a - b) for a, b in zip(found, expected, strict=True)) <= most


def check_tool(page, results):
    """The reamer is where forces.csv has the tool, and is seen to move."""
    with open(results / "forces.csv", encoding="utf-8") as file:
        rows = {int(row["frame"]): row for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    data = page.data()
    assert data["triangles"] >= 100
    last = len(data["frame"]) - 1
    looks = {}
    for row in (0, last // 2, last):
        page.set_slider("#time", row)
        logged = rows[data["frame"][row]]
        expected = [float(logged[f"tool_{axis}_mm"]) for axis in "xyz"]
        found = page.numbers("tool-mm")
        assert near(found, expected, 0.01), f"row {row}: the reamer is at {found}, and the log has {expected}"
        looks[row] = page.bone()
    assert changed_fraction(looks[0], looks[last // 2]) > 0.005, "the slider does not move the reamer"
    page.choose("tool", "steel")
    steel = page.bone()
    assert changed_fraction(looks[last], steel) > 0.005, "a reamer of steel looks like one of glass"
    page.choose("tool", "hidden")
    assert changed_fraction(steel, page.bone()) > 0.01, "the reamer cannot be hidden"
    page.set_slider("#time", 0)
    hidden = page.bone()
    page.set_slider("#time", last)
    assert changed_fraction(hidden, page.bone()) == 0, "a hidden reamer is seen to move"


def check_reaming(page):
    """The bone follows the slider from before to after; the reamer is hidden."""
    last = int(page.find("#time").get_attribute("max"))
    page.choose("state", "before")
    before = page.bone()
    page.choose("state", "after")
    after = page.bone()
    page.choose("state", "now")
    assert changed_fraction(after, page.bone()) < 0.01, "during the run, the end is not the bone after it"
    page.set_slider("#time", 0)
    assert changed_fraction(before, page.bone()) == 0, "during the run, the beginning is not the bone before it"
    removed = page.data()["removed"]
    half = next(i for i, volume in enumerate(removed) if volume > removed[last] / 2)
    page.set_slider("#time", half)
    middle = page.bone()
    assert min(changed_fraction(middle, other) for other in (before, after)) > 0.005, "the bone is not reamed step by step"


def check_views(page):
    """Buttons and sections turn the camera where their names say."""
    look = page.data()["look"]
    for button in page.driver.find_elements(By.CSS_SELECTOR, "#bone-views button"):
        page.click(button)
        if button.text in ("En face", "Along the axis"):
            assert near(page.numbers("towards-viewer"), look["outward"], 0.01), button.text
    section = Select(page.find("#cut-plane"))
    directions = {1: look["front"], 3: look["axis"]}
    for index, direction in directions.items():
        section.select_by_index(index)
        name = section.first_selected_option.text
        assert near(page.numbers("towards-viewer"), direction, 0.01), f"{name}: seen from {page.numbers('towards-viewer')}"
    page.click(page.find("#cut-flip"))
    assert near(page.numbers("towards-viewer"), [-v for v in look["axis"]], 0.01), "the other half is seen from outside"
    page.click(page.find("#cut-flip"))
    section.select_by_index(0)


def check_labels(page):
    """No two labels of the directions overlap, from wherever the bone is seen, and none leaves the view."""
    overlaps = page.driver.execute_script("""
      const canvas = document.getElementById('bone-canvas'), found = [];
      const press = (key) => canvas.dispatchEvent(new KeyboardEvent('keydown', {key}));
      for (let step = 0; step < 144; ++step) {
        press('ArrowRight');
        if (step % 12 === 5) press(step < 72 ? 'ArrowDown' : 'ArrowUp');
        const stage = canvas.getBoundingClientRect();
        const boxes = [...document.querySelectorAll('#bone-axes text')].map((e) => [e.textContent, e.getBoundingClientRect()]);
        boxes.forEach(([name, a], i) => {
          if (a.left < stage.left || a.right > stage.right || a.top < stage.top || a.bottom > stage.bottom) found.push(`${step}: ${name} outside`);
          for (const [other, b] of boxes.slice(i + 1))
            if (a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 2 && b.top < a.bottom - 2) found.push(`${step}: ${name} over ${other}`);
        });
      }
      return found;""")
    assert not overlaps, overlaps[:5]


def check_ranges(page):
    """The curves begin with the contact, say so, and show the whole run on request."""
    if not page.find("#plot-ranges").is_displayed():
        return
    page.choose("range", "contact")
    contact = page.find("#plot-range").text
    page.choose("range", "whole")
    whole = page.find("#plot-range").text
    assert contact != whole and whole.startswith("0.00 to"), f"{contact} became {whole}"
    page.choose("range", "contact")
    assert page.find("#plot-range").text == contact


def check_pictures(page, width):
    """Pictures are as wide as the page allows, and open at a size at which their text is readable."""
    room = page.driver.execute_script("return document.querySelector('main').clientWidth")
    for image in page.driver.find_elements(By.CSS_SELECTOR, ".gallery img, #frame-picture"):
        natural = int(image.get_attribute("naturalWidth"))
        assert image.size["width"] >= min(natural, room) - 1, f"{image.size} of {natural} px in a window of {width}"
    page.driver.execute_script("window.chosen = document.querySelector('.gallery .open-picture'); chosen.focus()")
    page.driver.switch_to.active_element.send_keys(Keys.ENTER)
    shown = page.find("#viewer img")
    assert shown.is_displayed() and shown.size["width"] >= min(960, int(shown.get_attribute("naturalWidth")))
    assert page.find("#viewer-caption").text
    page.driver.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not shown.is_displayed(), "Escape does not close the picture"
    assert page.driver.execute_script("return document.activeElement === chosen"), "the focus is lost"


NUMBERS = [(0, "0"), (726.6634, "726.7"), (-0.011907, "−0.01191"), (27319.31, "27\u2009319"), (9999.96, "10\u2009000"),
           (-8.2e-8, "−8.2 × 10⁻⁸"), (3301, "3301"), (0.25, "0.25"), (5.000000000000005, "5"), (28.99556, "29.00")]
MEASURED = [
    (0.273417, "mm", "0.27"), (28.99556, "mm", "29.00"), (0.4, "mm", "0.4"),  # a setting stays as it was set
    (0.0173, "mm", "0.017"),  # small values keep two digits
    (0.0007026, "mm³", "< 0.01"), (-0.0005953, "°", "0.00"), (0, "mm²", "0"), (-5.2187, "°", "−5.2"), (726.6634, "mm³", "726.7"),
    (27319.31, "mm³", "27\u2009319"), (908.31, "N·mm", "908"), (0.42, "N·mm", "0.4"), (84.4655, "%", "84.5"), (0.032914, "", "0.0329"),
    (-1.9e-8, "", "−1.9 × 10⁻⁸"), (12345, "", "12\u2009345"), (8, "", "8")]


def check_tables(page, results):
    """Figures and tables are those of summary.json, with its numbers rounded by their units."""
    for value, expected in NUMBERS:
        assert page.driver.execute_script("return report.numberText(arguments[0])", value) == expected, value
    for value, unit, expected in MEASURED:
        assert page.driver.execute_script("return report.measuredText(...arguments)", value, unit) == expected, (value, unit)
    summary = json.loads((results / "summary.json").read_text())
    shown = page.driver.execute_script("""
      const rows = (place) => [...document.querySelectorAll(`${place} tr`)].map((row) => [...row.cells].map((cell) => cell.textContent));
      const figures = [...document.querySelectorAll('.key-figures div')].map((figure) => [...figure.children].map((e) => e.textContent));
      return {figures, tables: rows('#tables'), provenance: rows('#provenance')};""")
    removed = summary["removed_mm3"]
    assert ["Bone removed", f"{removed:.{1 if removed < 1000 else 0}f} mm³"] in shown["figures"], shown["figures"]
    assert ["Frames", str(summary["frames"])] in shown["tables"], shown["tables"]
    assert ["Perforated", "yes" if summary["metrics"]["perforation"]["perforated"] else "no"] in shown["tables"], shown["tables"]
    assert ["Device", summary["device"]] in shown["provenance"], shown["provenance"]
    inputs = [[each["role"], pathlib.Path(each["path"]).name, each["sha256"]] for each in summary["inputs"]]
    assert all(row in shown["provenance"] for row in inputs), shown["provenance"]
    text = page.find("main").text
    assert all(warning in text for warning in summary["warnings"]), summary["warnings"]
    assert "contains no verification of the build" in text


def check_numbers(page):
    """No number of a table has digits that mean nothing."""
    long = [cell.text for cell in page.driver.find_elements(By.CSS_SELECTOR, ".tables td:not(.words), .key-figures dd")
            if sum(c.isdigit() for c in cell.text.split("×")[0].partition(".")[2]) > 4]
    assert not long, long


def check_names(page):
    """Every control has a name that a screen reader can say."""
    nameless = page.driver.execute_script("""
      return [...document.querySelectorAll('button, input, select, canvas, img, [role=img]')].filter((e) => e.getClientRects().length > 0 && !e.closest('[role=img] *') &&
        !(e.getAttribute('aria-label') || e.alt || e.textContent.trim() || e.querySelector('img')?.alt || (e.labels && e.labels.length > 0))).map((e) => e.outerHTML.slice(0, 80));""")
    assert not nameless, nameless


def check_width(page, width):
    wide = page.driver.execute_script("return document.documentElement.scrollWidth")
    assert wide <= width, f"the page is {wide} px wide in a window of {width}"


WIDE, NARROW = (1280, 900), (400, 800)


def check_page(browser, path, size):
    driver = browser.driver
    width, height = size
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
    page = Page(driver, path)
    check_width(page, width)
    report_access.check_rules(page)
    check_cursor(page)
    if size == WIDE:  # the 3D view does not depend on the window
        check_bone(page)
        check_tool(page, path.parent)
        check_reaming(page)
        check_views(page)
        check_tables(page, path.parent)
        check_numbers(page)
        report_access.check_motion(page)
    check_labels(page)
    check_ranges(page)
    check_pictures(page, width)
    check_names(page)
    report_access.check_keyboard(page)
    report_access.check_paper(page)
    check_loads_alone(driver, path)
    report_access.check_without_scripts(page)


def main():
    *programs, results = sys.argv[1:]
    path = pathlib.Path(results) / "report.html"
    assert path.stat().st_size < MOST_BYTES, f"{path.stat().st_size} bytes"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:  # Chromium may still write
        for size in (WIDE, NARROW):
            browser = Browser(programs, pathlib.Path(folder) / str(size[0]), *size)
            try:
                check_page(browser, path, size)
            finally:
                browser.close()


if __name__ == "__main__":
    main()
