"""report_page.py CHROMIUM CHROMEDRIVER RESULTS: opens RESULTS/report.html in a headless Chromium and uses it as a reader would."""

import io
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from PIL import Image, ImageChops
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.common.utils import is_connectable
from selenium.webdriver.support.ui import Select, WebDriverWait

MOST_BYTES = 15_000_000
FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-dev-shm-usage",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--force-device-scale-factor=1",
    # WebGL on the CPU, and no way out of this machine.
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--host-resolver-rules=MAP * ~NOTFOUND",
]


class Driver(webdriver.chrome.service.Service):
    """Found by its number: a bare Debian has no /etc/hosts that knows localhost."""

    @property
    def service_url(self):
        return f"http://127.0.0.1:{self.port}"

    def is_connectable(self):
        return is_connectable(self.port, "127.0.0.1")


class Browser:
    """A Chromium of its own profile and the driver that steers it. It is started here and found by its port, because the
    driver would look for it on localhost."""

    def __init__(self, programs, profile, width, height):
        chromium, chromedriver = programs
        self.process = subprocess.Popen(
            [chromium, *FLAGS, "--remote-debugging-port=0", f"--user-data-dir={profile}", f"--window-size={width},{height}"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        options = webdriver.ChromeOptions()
        options.debugger_address = f"127.0.0.1:{self.port(profile / 'DevToolsActivePort')}"
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Driver(chromedriver))

    def port(self, file):
        for _ in range(600):
            assert self.process.poll() is None, f"Chromium ended with status {self.process.returncode}"
            if file.exists() and file.read_text().count("\n") > 0:
                return int(file.read_text().split()[0])
            time.sleep(0.1)
        raise TimeoutError("Chromium has opened no port within a minute")

    def close(self):
        self.driver.quit()
        self.process.terminate()
        self.process.wait(60)


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

    def bone(self):
        """The 3D view as it stands on the screen."""
        time.sleep(0.3)
        return Image.open(io.BytesIO(self.find("#bone-canvas").screenshot_as_png)).convert("RGB")

    def pictured_frame(self):
        return int(self.find("#frame-picture").get_attribute("data-frame"))

    def choose(self, name, value):
        self.find(f"input[name={name}][value={value}]").click()


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
    page.driver.execute_script("document.getElementById('bone').scrollIntoView({behavior: 'instant'})")
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
    assert changed_fraction(after, page.bone()) < 0.001, "the section does not close again"
    page.find("#bone-canvas").send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert changed_fraction(after, page.bone()) > 0.01, "arrow keys do not turn the bone"


def check_names(page):
    """Every control has a name that a screen reader can say."""
    nameless = page.driver.execute_script("""
      return [...document.querySelectorAll('button, input, select, canvas, img, [role=img]')].filter((e) => e.getClientRects().length > 0 && !e.closest('[role=img] *') &&
        !(e.getAttribute('aria-label') || e.alt || e.textContent.trim() || (e.labels && e.labels.length > 0))).map((e) => e.outerHTML.slice(0, 80));""")
    assert not nameless, nameless


def check_width(page, width):
    wide = page.driver.execute_script("return document.documentElement.scrollWidth")
    assert wide <= width, f"the page is {wide} px wide in a window of {width}"


def main():
    *programs, results = sys.argv[1:]
    path = pathlib.Path(results) / "report.html"
    assert path.stat().st_size < MOST_BYTES, f"{path.stat().st_size} bytes"
    with tempfile.TemporaryDirectory() as folder:
        for width, height in ((1400, 1000), (400, 800)):
            browser = Browser(programs, pathlib.Path(folder) / str(width), width, height)
            driver = browser.driver
            try:
                driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                       {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
                page = Page(driver, path)
                check_width(page, width)
                check_cursor(page)
                check_bone(page)
                check_names(page)
                check_loads_alone(driver, path)
            finally:
                browser.close()


if __name__ == "__main__":
    main()
