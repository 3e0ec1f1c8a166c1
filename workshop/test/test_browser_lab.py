"""JupyterLab shows the guide, has terminals with the workshop's display, and saves files."""

import subprocess

import pytest
from headless_browser import CANVAS, picture_of, save_screenshot, served, wait_until
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from sdc_testing.chromium import headless_chromium, wait_for
from sdc_workshop.workspace import PROJECT, make

pytestmark = [pytest.mark.slow(60), pytest.mark.nightly]

# Standard deviation of a desktop that is not empty [0..255].
DRAWN = 20.0
READY = "return window.jupyterapp ? jupyterapp.restored.then(() => true) : false"
GUIDE = """
return [...document.querySelectorAll('.jp-RenderedMarkdown')].map((one) => one.innerText).join("")
"""
# The link to a page of the guide.
PAGE = ".jp-RenderedMarkdown a[href*='Phase%20{}.md']"
# Solutions behind a fold.
FOLDED = "return document.querySelectorAll('.jp-RenderedMarkdown details:not([open]) pre').length"
FIRST_TERMINAL = (
    "return document.querySelector('.jp-Terminal')?.getBoundingClientRect().width > 300"
)
FILES = (
    "return [...document.querySelectorAll('.jp-DirListing-itemText')].map((one) => one.innerText)"
)
OPEN_TERMINAL = """
const widget = await jupyterapp.commands.execute("terminal:create-new");
window.terminal = widget.content;
await widget.content.ready;
"""
KEYBOARD = "return window.terminal._term.textarea"
# The lines on the screen, those that are too long joined again.
TEXT = """
const buffer = window.terminal._term.buffer.active;
let text = "";
for (let i = 0; i < buffer.length; i++) {
  const goesOn = buffer.getLine(i + 1)?.isWrapped ?? false;
  text += buffer.getLine(i).translateToString(!goesOn) + (goesOn ? "" : "\\n");
}
return text;
"""
OPEN_FILE = """
const path = arguments[0];
const widget = await jupyterapp.commands.execute("docmanager:open", {path, factory: "Editor"});
await widget.context.ready;
widget.context.model.sharedModel.setSource("mine\\n");
await widget.context.save();
"""


def run(browser, script, *arguments):
    """Run a script that waits for promises."""
    return browser.execute_async_script(
        f"const done = arguments[arguments.length - 1]; (async function () {{{script}}})"
        ".apply(null, arguments).then(done, (error) => done(String(error)))",
        *arguments,
    )


@pytest.fixture(scope="module")
def jupyterlab():
    done = subprocess.run(
        [PROJECT / "docker" / "prepare", "browser"], stderr=subprocess.PIPE, text=True, check=False
    )
    if done.returncode != 0:
        pytest.skip(f"JupyterLab could not be installed: {done.stderr.splitlines()[-1]}")


@pytest.fixture
def browser(jupyterlab, tmp_path):
    make(tmp_path / "sdc_ws")
    (tmp_path / "sdc_ws" / "devel").mkdir()
    (tmp_path / ".jupyter").mkdir()
    (tmp_path / ".jupyter" / "jupyter_lab_config.json").write_text(
        '{"LabApp": {"expose_app_in_browser": true}}', encoding="utf-8"
    )
    with served("browser", tmp_path) as (_, url), headless_chromium(1600, 1000) as browser:
        browser.get(url)
        wait_until(lambda: browser.execute_script(READY), "JupyterLab")
        yield browser


def test_jupyterlab_has_guide_terminal_editor_and_desktop(browser, tmp_path):
    buttons = "Watch a drive Cockpit Next step: The workspace is built"
    wait_until(lambda: buttons in browser.execute_script(GUIDE), "the rendered guide")
    find = browser.find_elements
    find(By.CSS_SELECTOR, PAGE.format(1))[0].click()
    wait_until(lambda: f"cd {PROJECT}\n" in browser.execute_script(GUIDE), "the page of phase 1")
    find(By.CSS_SELECTOR, PAGE.format(2))[-1].click()
    wait_until(lambda: browser.execute_script(FOLDED) > 2, "the page of phase 2")
    assert "~/workshop" not in browser.execute_script(GUIDE)
    wait_until(lambda: browser.execute_script(FIRST_TERMINAL), "the terminal beside the guide")
    wait_until(lambda: "src" in browser.execute_script(FILES), "the files of the workspace")
    assert not {"build", "devel"} & set(browser.execute_script(FILES))
    run(browser, OPEN_TERMINAL)
    command = (
        "which python3; echo ${VIRTUAL_ENV-none}; (xterm -title mine &); echo display $DISPLAY"
    )
    browser.execute_script(KEYBOARD).send_keys(command + Keys.ENTER)

    def shown():
        return browser.execute_script(TEXT)

    wait_until(lambda: "\ndisplay :" in shown(), "the display of a terminal")
    assert "/usr/bin/python3\nnone\n" in shown()

    path = tmp_path / "sdc_ws" / "src" / "sdc_package" / "scripts" / "camera.py"
    assert run(browser, OPEN_FILE, str(path).lstrip("/")) is None
    assert path.read_text(encoding="utf-8") == "mine\n"
    assert not list((tmp_path / "sdc_ws" / "src").rglob(".ipynb_checkpoints"))

    browser.execute_script("jupyterapp.commands.execute('launcher:create')")
    tile = ".jp-LauncherCard[title*=Desktop]"
    wait_until(lambda: find(By.CSS_SELECTOR, tile), "the tile of the desktop")[0].click()
    frame = wait_until(lambda: find(By.CSS_SELECTOR, "iframe[src*=desktop]"), "the desktop")[0]
    browser.switch_to.frame(frame)

    def shows_window():
        picture = picture_of(browser, CANVAS)
        return picture is not None and picture.std() > DRAWN

    wait_until(shows_window, "the picture of the window")
    browser.switch_to.default_content()
    cockpit = find(By.CSS_SELECTOR, ".jp-RenderedMarkdown a[href$=drive]")[0].get_attribute("href")
    save_screenshot(browser, "browser.png")
    browser.get(cockpit)
    wait_for(browser, "window.cockpit && cockpit.picture.drawn > 0")
