"""A headless Chromium for pages of reports (Debian: chromium-driver, python3-selenium)."""
import json
import pathlib
import shutil
import unittest

from program import CARILLON, run

try:
    from selenium import webdriver
    from selenium.webdriver import ActionChains, Keys
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = ActionChains = Keys = None

DRIVER = shutil.which("chromedriver")
BROWSER = shutil.which("chromium")
# What the page is built with (cmake/CarillonPage.cmake).
AXE = pathlib.Path(CARILLON).parent / "report-page/node_modules/axe-core/axe.min.js"

VIOLATIONS = """
    const done = arguments[0];
    axe.run({runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'], resultTypes: ['violations']}).then(
      ({violations, passes}) => done({passed: passes.map(({id}) => id),
        violations: violations.flatMap(({id, nodes}) => nodes.map(({target, failureSummary}) =>
          `${id}: ${target.join(' ')}: ${failureSummary}`))}),
      (error) => done({passed: [], violations: [String(error)]}));"""
NONE = "no chromium, chromedriver or selenium (Debian: chromium-driver, python3-selenium)"


def there():
    return bool(webdriver and DRIVER and BROWSER)


def needs_browser(test):
    return unittest.skipUnless(there(), NONE)(test)


def start():
    """A browser; the caller quits it."""
    options = Options()
    # As root in a container there is no sandbox; WebGL is drawn by the processor.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                     "--autoplay-policy=no-user-gesture-required"):
        options.add_argument(argument)
    options.binary_location = BROWSER
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(service=Service(DRIVER), options=options)
    driver.set_script_timeout(60)
    return driver


def screen(driver, width=1280, height=900, dark=False):
    """As wide as a screen or a telephone's."""
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1,
                            "mobile": width < 600})
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})


def show(driver, page, width=1280, height=900, dark=False):
    """Opens a page anew, a file's or an address, on such a screen; what was logged before is forgotten."""
    driver.get_log("browser"), driver.get_log("performance")
    screen(driver, width, height, dark)
    driver.get(page if isinstance(page, str) else page.resolve().as_uri())
    return driver


def look_through(driver):
    """Scrolls to the end, so that everything is drawn."""
    driver.execute_async_script("""
        const done = arguments[0]; let at = 0;
        const step = () => { scrollTo({top: at, behavior: 'instant'}); at += 700;
          at > document.documentElement.scrollHeight ? setTimeout(done, 500) : setTimeout(step, 60); };
        step();""")


def expect_whole(test, driver, width):
    """Nothing went wrong, nothing was fetched, all charts are drawn that are not folded away, nothing is
    wider than the screen. Gives the number of charts."""
    look_through(driver)
    faults = [e for e in driver.get_log("browser") if e["level"] in ("SEVERE", "ERROR")]
    test.assertEqual(faults, [])
    requests = [json.loads(e["message"])["message"] for e in driver.get_log("performance")]
    urls = {r["params"]["request"]["url"][:5] for r in requests
            if r["method"] == "Network.requestWillBeSent"}
    test.assertLessEqual(urls, {"file:", "data:", "blob:"})
    test.assertLessEqual(driver.execute_script("return document.documentElement.scrollWidth"), width)
    test.assertNotIn("cannot be drawn", driver.execute_script("return document.querySelector('main').textContent"))
    empty, drawn = driver.execute_script("""
        const charts = [...document.querySelectorAll('figure > .chart')].filter((chart) => !chart.closest('details:not([open])'));
        const is_drawn = (chart) => chart.querySelector('svg[role=img][aria-label]');
        return [charts.filter((c) => !is_drawn(c)).length, charts.filter(is_drawn).length];""")
    test.assertEqual(empty, 0)
    return drawn


def expect_sections(test, path, expected):
    """The page has these sections (the beginnings of their ids), each with something to see or hear, at the
    width of a screen and of a telephone."""
    driver = start()
    test.addCleanup(driver.quit)
    for width in (1280, 390):
        expect_whole(test, show(driver, path, width), width)
        found = driver.execute_script("""
            return [...document.querySelectorAll('section')]
              .map((one) => [one.id, one.querySelectorAll('tbody tr, svg, canvas, audio').length]);""")
        for prefix in expected:
            test.assertTrue([n for name, n in found if name.startswith(prefix) and n > 0],
                            (prefix, found))


def expect_report(test, folder, expected):
    """`carillon report` of the folder has these sections."""
    if not there():
        test.skipTest(NONE)
    page = test.folder / "report.html"
    made = run("report", folder, "-o", page)
    if "built without the page" in made.stderr:
        test.skipTest("this program was built without the page of reports")
    test.assertEqual(made.returncode, 0, made.stderr)
    expect_sections(test, page, expected)


def violations(test, driver):
    """What axe-core finds on the page as it is; it has looked at colours, too."""
    driver.execute_script(AXE.read_text())
    found = driver.execute_async_script(VIOLATIONS)
    test.assertIn("color-contrast", found["passed"])
    return found["violations"]


def expect_access(test, driver, width):
    """Everyone can use the page as it is: axe-core finds nothing, and it is no wider than the screen."""
    test.assertEqual(violations(test, driver), [])
    test.assertLessEqual(driver.execute_script("return document.documentElement.scrollWidth"), width)


def press(driver, *keys):
    ActionChains(driver).send_keys(*keys).perform()


def click(driver, element):
    """In the middle of an element."""
    ActionChains(driver).move_to_element(element).click().perform()
