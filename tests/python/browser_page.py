"""The page of `cargo xtask page` in headless Chromium, compared with `motor-fmu steady` and `simulate`; run by `cargo xtask nightly`.

Not part of the everyday tests, because Chromium and a second compilation of the models are needed.
"""

import base64
import csv
import json
import math
import shutil
from urllib.parse import urlencode

import pytest
from clients import paths
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

PAGE = paths.dist() / "page.html"
RPM = 2 * math.pi / 60
# The C library and WebAssembly round pow and exp differently.
RELATIVE = 1e-9
START = {
    "cooling": "", "fan": 0, "ambient": 25, "voltage": 24, "load": "current", "torque": 0.1, "current": 5, "speed": 0,
    "activity": "walk", "joint": "ankle", "body_mass": 75, "support": 0.5, "ratio": 250, "stiffness": 250, "minutes": 30,
}  # fmt: skip
# Motor, cooling and current of their own: none is the page's start.
CASES = {
    "re40": {"motor": "maxon-re40-148877", "current": 2.5, "speed": 3000, "voltage": 48, "minutes": 20},
    "annulus": {"motor": "thesis-rig", "cooling": "annulus_pull", "fan": 0.6, "current": 4, "ambient": 35},
    "crossflow": {"motor": "maxon-305015", "cooling": "fan_crossflow", "fan": 1, "current": 7.3, "speed": 500},
}


@pytest.fixture(scope="module")
def browser():
    """Headless Chromium under its driver."""
    for program in ("chromium", "chromedriver"):
        assert shutil.which(program), f"{program} is not on the path; on Debian: `apt-get install chromium chromium-driver`"
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for option in ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync"):
        options.add_argument(option)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    yield driver
    driver.quit()


def wait(browser, state="ready"):
    """Waits until the page has computed."""
    computed = "return document.documentElement.dataset.state"
    WebDriverWait(browser, 120).until(lambda b: b.execute_script(computed) == state, f"the page is not {state}")
    assert browser.get_log("browser") == []


def open_page(browser, state, width=1400, scheme="light"):
    """Opens the page in a state and waits until it has computed."""
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    )
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    browser.get("about:blank")
    browser.get(f"{PAGE.as_uri()}#{urlencode(START | state)}")
    wait(browser)


def text(browser, question):
    return browser.find_element(By.CSS_SELECTOR, f"#{question} .text").text


def answers(browser, state):
    """Values of the page by question; every answer has a figure and a sentence."""
    open_page(browser, state)
    found = {}
    for question in ("heating", "range", "efficiency"):
        assert text(browser, question).endswith(".")
        assert "NaN" not in browser.find_element(By.CSS_SELECTOR, f"#{question} svg").get_attribute("outerHTML")
        values = browser.find_element(By.CSS_SELECTOR, f"#{question} .values").get_attribute("textContent")
        found[question] = json.loads(values)
    return found


def settings(case):
    """The state as settings of `motor-fmu`, in SI units."""
    state = START | case
    sets = {
        "drive_mode": "current", "mechanical_mode": "imposed_speed", "fan_command": state["fan"],
        "ambient_temperature": state["ambient"] + 273.15, "current_command": state["current"], "imposed_speed": state["speed"] * RPM,
    }  # fmt: skip
    if state["cooling"]:
        sets["cooling_mode"] = state["cooling"]
    return [part for name, value in sets.items() for part in ("--set", f"{name}={value}")]


@pytest.mark.parametrize("name", CASES)
def test_the_page_equals_the_program(name, browser, motor_fmu, tmp_path):
    case = CASES[name]
    found = answers(browser, case)
    heating = found["heating"]

    steady = motor_fmu("steady", "--json", "--preset", case["motor"], *settings(case))
    assert steady.returncode == 0, steady.stderr
    steady = json.loads(steady.stdout)
    for variable in ("winding_temperature", "housing_temperature", "shaft_torque"):
        assert heating["steady"][variable] == pytest.approx(steady["steady"][variable], rel=RELATIVE)
    if case.get("speed", 0) == 0:
        at_rest = found["range"]["rows"][0]["continuous"]
        assert at_rest == pytest.approx(steady["continuous"]["torque"], rel=RELATIVE)

    motor_fmu("build", "AnnulusCooledMotor", "--fmi", "3", "--preset", case["motor"], "--out", "built")
    stop = 60 * (START | case)["minutes"]
    run = motor_fmu(
        "simulate", "built/fmi3/AnnulusCooledMotor.fmu", "--stop", stop, "--step", stop / 300, "--output", "run.csv", *settings(case)
    )
    assert run.returncode == 0, run.stderr
    with open(tmp_path / "run.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(heating["time"]) == 301
    for k, row in enumerate(rows):
        for variable in ("winding_temperature", "housing_temperature"):
            assert heating[variable][k] == pytest.approx(float(row[variable]), rel=RELATIVE), f"row {k}"


def test_a_gait_equals_the_program(browser, motor_fmu, tmp_path):
    state = {"motor": "maxon-305015", "load": "gait", "activity": "stairs_up", "joint": "knee", "body_mass": 82, "support": 0.4, "voltage": 36}
    walked = answers(browser, state)["heating"]
    (tmp_path / "gait.toml").write_text(
        '[gait]\n"gait.activity" = "stairs_up"\n"gait.joint" = "knee"\n"gait.body_mass" = 82\n"gait.support" = 0.4\n'
        '[actuator]\n"transmission.ratio" = 250\n"spring.stiffness" = 250\nsupply_voltage = 36\n[motor]\ndrive_mode = "current"\n'
    )
    native = motor_fmu("steady", "--load", "gait.toml", "--hours", "0.5", "--preset", "maxon-305015", "--json")
    assert native.returncode == 0, native.stderr
    native = json.loads(native.stdout)
    assert walked["continuous"]["support"] == pytest.approx(native["continuous"]["support"], rel=1e-6)
    assert walked["walk"]["envelope"]["time_to_limit"] == pytest.approx(native["time_to_limit"], rel=1e-6)


@pytest.mark.parametrize("width", (420, 1400))
@pytest.mark.parametrize("scheme", ("dark", "light"))
def test_the_page_fits_its_window(width, scheme, browser, tmp_path):
    """Nothing is wider than the window; the colours follow the scheme."""
    open_page(browser, CASES["re40"], width, scheme)
    wide = "return [document.documentElement.scrollWidth, getComputedStyle(document.body).backgroundColor]"
    found, background = browser.execute_script(wide)
    assert found <= width
    assert (background == "rgb(255, 255, 255)") == (scheme == "light")
    page = browser.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True})
    (tmp_path / f"page-{width}-{scheme}.png").write_bytes(base64.b64decode(page["data"]))


def test_the_keyboard_changes_the_load_and_the_link_keeps_it(browser):
    """Tab reaches every control in the order of the page; typing computes again; the link shows the same page."""
    open_page(browser, CASES["re40"])
    before = text(browser, "heating")
    visible = "return [...document.querySelectorAll('.controls select, .controls input')].filter(c => c.offsetParent).map(c => c.id)"
    controls, reached = browser.execute_script(visible), []
    browser.execute_script("document.getElementById('motor').focus()")
    for _ in controls:
        reached.append(browser.switch_to.active_element.get_attribute("id"))
        browser.switch_to.active_element.send_keys(Keys.TAB)
    assert reached == controls
    current = browser.find_element(By.ID, "current")
    current.send_keys(Keys.CONTROL + "a")
    current.send_keys("3.75")
    WebDriverWait(browser, 60).until(lambda b: text(b, "heating") != before, "typing computes nothing")
    wait(browser)
    after, link = text(browser, "heating"), browser.current_url
    assert "current=3.75" in link
    browser.get("about:blank")
    browser.get(link)
    wait(browser)
    assert text(browser, "heating") == after


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ({"motor": "maxon-305015", "load": "torque", "torque": 900}, "gives the torque 900 N.m"),
        ({"motor": "maxon-305015", "current": 400}, "The winding reaches its limit"),
    ],
)
def test_what_cannot_be_computed_is_one_sentence(state, words, browser):
    open_page(browser, state)
    assert words in text(browser, "heating")


def test_a_value_outside_its_limits_is_named(browser):
    open_page(browser, CASES["re40"])
    fan = browser.find_element(By.ID, "fan")
    fan.send_keys(Keys.CONTROL + "a")
    fan.send_keys("1.5")
    wait(browser, "invalid")
    assert "Fan speed" in browser.find_element(By.ID, "status").text


def test_models_that_do_not_start_are_reported(browser, tmp_path):
    """As in a browser that has no WebAssembly: the page says so and does not go on waiting."""
    before, after = PAGE.read_text(encoding="utf-8").split('<script id="models" type="text/plain">')
    file = tmp_path / "page.html"
    file.write_text(before + '<script id="models" type="text/plain">AGFzbQ==' + after[after.index("</script>") :], encoding="utf-8")
    browser.get(file.as_uri())
    state = "return document.documentElement.dataset.state"
    WebDriverWait(browser, 30).until(lambda b: b.execute_script(state) == "failed", "the page waits")
    assert browser.find_element(By.ID, "status").text.startswith("The computation stopped: ")
    browser.get_log("browser")
