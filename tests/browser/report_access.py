# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Whether everybody can use report.html: the rules of axe-core, the keyboard, reduced motion, paper."""

import base64
import pathlib
import re
import time

from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

AXE = pathlib.Path(__file__).with_name("axe.min.js")
PAPER_IN = {"A4": (8.27, 11.69), "Letter": (8.5, 11)}
MOST_PAGES = 3


def check_rules(page):
    """axe-core finds nothing to complain of."""
    page.driver.execute_script(AXE.read_text(encoding="utf-8"))
    page.driver.set_script_timeout(120)
    found = page.driver.execute_async_script("""
      const done = arguments[0];
      axe.run(document, {resultTypes: ['violations']}).then(
        (r) => done({rules: r.passes.length, violations: r.violations.map((v) => `${v.impact} ${v.id}: ${v.nodes.map((n) => n.html.slice(0, 100))}`)}),
        (error) => done({rules: 0, violations: [String(error)]}));""")
    assert not found["violations"], found["violations"]
    assert found["rules"] > 20, f"only {found['rules']} rules apply"


def check_keyboard(page):
    """Tab reaches every control, and each shows that it has the focus."""
    # Of a group of radio buttons Tab reaches the chosen one.
    controls = page.driver.execute_script("""
      window.controls = [...document.querySelectorAll('a[href], button, select, input, [tabindex="0"]')].filter((e) =>
        e.getClientRects().length > 0 && !e.disabled && !e.closest('dialog') && !(e.type === 'radio' && !e.checked));
      window.reached = new Set();
      document.activeElement.blur();
      scrollTo(0, 0);
      return controls.length;""")
    assert controls > 15
    page.find("body").send_keys(Keys.TAB)
    for _ in range(controls + 5):
        page.driver.execute_script("""
          const e = document.activeElement, style = getComputedStyle(e);
          if (style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 1) reached.add(e);""")
        page.driver.switch_to.active_element.send_keys(Keys.TAB)
    missed = page.driver.execute_script("return controls.filter((e) => !reached.has(e)).map((e) => e.outerHTML.slice(0, 100))")
    assert not missed, f"Tab does not reach {missed}, or does not show it"
    before = page.bone().tobytes()
    for keys in ("+", Keys.SHIFT + Keys.ARROW_LEFT + Keys.NULL):
        page.find("#bone-canvas").send_keys(keys)
        after = page.bone().tobytes()
        assert after != before, f"the key {keys!r} changes nothing in the 3D view"
        before = after


def set_media(page, medium, motion):
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
        "media": medium, "features": [{"name": "prefers-reduced-motion", "value": motion}]})
    time.sleep(0.3)


def check_motion(page):
    """Nothing moves by itself where a reader wants less motion; otherwise the run plays."""
    play, slider = page.find("#play"), page.find("#time")
    value = lambda: int(slider.get_attribute("value"))
    page.set_slider("#time", 0)
    set_media(page, "", "reduce")
    assert play.text == "Next"
    assert page.driver.execute_script("return getComputedStyle(document.documentElement).scrollBehavior") == "auto"
    play.send_keys(Keys.ENTER)
    stepped = value()
    assert stepped > 0
    time.sleep(0.5)
    assert value() == stepped, "it moves on by itself"
    set_media(page, "", "no-preference")
    assert play.text == "Play"
    play.send_keys(Keys.ENTER)
    assert play.text == "Pause"
    WebDriverWait(page.driver, 20).until(lambda _: value() > stepped)
    WebDriverWait(page.driver, 60).until(lambda _: play.text == "Play" and value() == int(slider.get_attribute("max")))


def check_without_scripts(page):
    """Pictures take the place of 3D view and curves, plain tables that of tables."""
    page.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        page.driver.refresh()
        shown = {selector: page.find(selector).rect["height"] > 0
                 for selector in ("#bone-still img", "#run img.print-only", "noscript table", "#bone-interactive", "#timeline", "#run-interactive",
                                   "#tables", "#verification", "#provenance")}
        plain = page.find("main").text
    finally:
        page.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
    assert list(shown.values()) == [True] * 3 + [False] * 6, shown
    for word in ("Bone removed", "Energy balance", "Voxel", "Force law", "SHA-256"):
        assert word in plain, f"{word} is missing without scripts"


def check_paper(page):
    """Three pages, with the bone on the first, from every window."""
    for name, (width, height) in PAPER_IN.items():
        pdf = base64.b64decode(page.driver.execute_cdp_cmd("Page.printToPDF", {
            "paperWidth": width, "paperHeight": height, "preferCSSPageSize": False})["data"])
        pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
        assert 1 <= pages <= MOST_PAGES, f"{pages} pages of {name}"
        first = base64.b64decode(page.driver.execute_cdp_cmd("Page.printToPDF", {
            "paperWidth": width, "paperHeight": height, "pageRanges": "1"})["data"])
        widths = [int(w) for w in re.findall(rb"/Width (\d+)", first)]
        natural = int(page.find("#bone-still img").get_attribute("naturalWidth"))
        assert natural in widths, f"{name}: the first page has pictures of {widths} px, and the bone's has {natural}"
