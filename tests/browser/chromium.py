# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""A headless Chromium without a way out of this machine, and the driver that steers it."""

import subprocess
import time

from selenium import webdriver
from selenium.webdriver.common.utils import is_connectable

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
