"""A headless Chromium for pages of reports (Debian: chromium-driver, python3-selenium)."""
import shutil
import unittest

try:
    from selenium import webdriver
    from selenium.webdriver import ActionChains
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None

DRIVER = shutil.which("chromedriver")
BROWSER = shutil.which("chromium")


def needs_browser(test):
    there = webdriver and DRIVER and BROWSER
    return unittest.skipUnless(there, "no chromium, chromedriver or selenium (Debian: "
                                      "chromium-driver, python3-selenium)")(test)


def open_page(path, width=1280, height=900, dark=False):
    """A driver with the page open, as wide as a screen or a telephone's; the caller quits it."""
    options = Options()
    # As root in a container there is no sandbox; WebGL is drawn by the processor.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                     "--autoplay-policy=no-user-gesture-required"):
        options.add_argument(argument)
    options.binary_location = BROWSER
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(service=Service(DRIVER), options=options)
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1,
                            "mobile": width < 600})
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    driver.set_script_timeout(60)
    driver.get(path.resolve().as_uri())
    return driver


def click(driver, element):
    """In the middle of an element."""
    ActionChains(driver).move_to_element(element).click().perform()
