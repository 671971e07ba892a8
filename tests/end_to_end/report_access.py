"""Whoever uses the page of `carillon report` without a mouse, without colours or with a screen reader: axe-core's
rules of WCAG 2.1 A and AA, and the keyboard. A part of report.py, whose page has every kind of section."""
from browser import Keys, expect_access, look_through, needs_browser, press, violations

CONTROLS = """
    return [...document.querySelectorAll('a[href], button, input, select, summary, audio, [tabindex="0"]')].filter(
      (one) => one.checkVisibility() && !one.disabled && one.tabIndex >= 0 && (one.type !== 'radio' || one.checked));"""

FOCUSED = """
    const one = document.activeElement;
    const {outlineStyle, outlineWidth} = getComputedStyle(one);
    return [one, outlineStyle !== 'none' && parseFloat(outlineWidth) > 0];"""


class Access:
    @needs_browser
    def test_axe_finds_nothing(self):
        for width in (1280, 390):
            for dark in (False, True):
                with self.subTest(width=width, dark=dark):
                    driver = self.open(width, dark)
                    self.js("for (const one of document.querySelectorAll('details')) one.open = true;")
                    look_through(driver)
                    expect_access(self, driver, width)
                    # What is opened, too.
                    self.js("document.querySelector('#samples button[value=table]').click()")
                    self.js("document.querySelector('#samples button[aria-haspopup]').click()")
                    expect_access(self, driver, width)

    @needs_browser
    def test_axe_sees_what_is_wrong(self):
        driver = self.open()
        self.js("document.querySelector('h1').style.color = '#dddddd'; document.querySelector('#samples select').parentNode.replaceWith(document.createElement('input'))")
        found = violations(self, driver)
        self.assertTrue([one for one in found if one.startswith("color-contrast: h1")], found)
        self.assertTrue([one for one in found if one.startswith("label: ")], found)

    @needs_browser
    def test_tab_comes_to_every_control_and_shows_it(self):
        driver = self.open()
        look_through(driver)
        self.js("scrollTo({top: 0, behavior: 'instant'})")
        controls = self.js(CONTROLS)
        self.assertGreater(len(controls), 60)
        reached, unseen = set(), []
        # Players have several buttons each.
        for _ in range(len(controls) + 6 * len(self.js("return document.querySelectorAll('audio')"))):
            press(driver, Keys.TAB)
            one, is_shown = self.js(FOCUSED)
            if one.tag_name == "body":
                break
            reached.add(one)
            if not is_shown and one.tag_name != "audio":
                unseen.append(one.get_attribute("outerHTML")[:100])
        self.assertEqual([one.get_attribute("outerHTML")[:100] for one in controls if one not in reached], [])
        self.assertEqual(unseen, [])

    @needs_browser
    def test_keys_do_what_clicks_do(self):
        driver = self.open()
        press(driver, Keys.TAB)
        self.assertEqual(self.js("return document.activeElement.getAttribute('href')"), "#content")
        press(driver, Keys.ENTER)
        press(driver, Keys.TAB)
        self.assertTrue(self.js("return document.querySelector('#content').contains(document.activeElement)"))
        focus = "document.querySelector(arguments[0]).focus()"
        state = "return document.querySelector(arguments[0]).getAttribute(arguments[1])"
        head = "#dataset-0 th"
        for key, order in ((Keys.ENTER, "ascending"), (Keys.SPACE, "descending")):
            self.js(focus, f"{head} button")
            press(driver, key)
            self.assertEqual(self.js(state, head, "aria-sort"), order)
        self.js(focus, "#samples button[value=table]")
        press(driver, Keys.SPACE)
        self.assertEqual(self.js(state, "#samples button[value=table]", "aria-pressed"), "true")
        self.assertEqual(len(self.js("return document.querySelectorAll('#samples tbody tr')")), 12)
        self.js(focus, "#samples button[aria-haspopup]")
        press(driver, Keys.ENTER)
        self.assertEqual(len(self.js("return document.querySelectorAll('dialog[open]')")), 1)
        press(driver, Keys.ESCAPE)
        self.assertEqual(len(self.js("return document.querySelectorAll('dialog[open]')")), 0)
        self.assertEqual(self.js("return document.activeElement.getAttribute('aria-haspopup')"), "dialog")
        self.js("document.querySelector('#dataset-0 summary').focus()")
        press(driver, Keys.SPACE)
        self.assertTrue(self.js("return document.querySelector('#dataset-0 details').open"))
