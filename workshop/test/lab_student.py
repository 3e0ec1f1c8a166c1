"""A student who follows the guide in JupyterLab's terminals and editor."""

from guide_student import PROMPT, Student
from headless_browser import wait_until
from selenium.webdriver.common.keys import Keys

from sdc_common.testing.virtual_display import VirtualDisplay
from sdc_workshop.regions import replaced

OPEN_TERMINAL = """
const [name, done] = arguments;
window.terminals ??= {};
const widget = await jupyterapp.commands.execute("terminal:create-new");
window.terminals[name] = widget;
await widget.content.ready;
widget.content._term.options.scrollback = 20000;
done();
"""
# The lines on the screen, those that are too long joined again.
TEXT = """
const buffer = window.terminals[arguments[0]].content._term.buffer.active;
let text = "";
for (let i = 0; i < buffer.length; i++) {
  const goesOn = buffer.getLine(i + 1)?.isWrapped ?? false;
  text += buffer.getLine(i).translateToString(!goesOn) + (goesOn ? "" : "\\n");
}
return text.trimEnd();
"""
KEYBOARD = """
const widget = window.terminals[arguments[0]];
jupyterapp.shell.activateById(widget.id);
if (arguments[1]) widget.content._term.clear();
return widget.content._term.textarea;
"""
CREATE_FILE = """
const [folder, path, done] = arguments;
const contents = jupyterapp.serviceManager.contents;
const file = await contents.newUntitled({path: folder, type: "file"});
await contents.rename(file.path, path);
done();
"""
OPEN_FILE = """
const [path, done] = arguments;
const widget = await jupyterapp.commands.execute("docmanager:open", {path, factory: "Editor"});
await widget.context.ready;
widget.content.editor.focus();
window.editor = widget;
done(widget.content.editor.editor.contentDOM);
"""
PASTE = """
const clipboardData = new DataTransfer();
clipboardData.setData("text/plain", arguments[1]);
arguments[0].dispatchEvent(new ClipboardEvent("paste", {clipboardData, bubbles: true}));
"""
SAVED = "return !window.editor.context.model.dirty"


def run_async(browser, script, *arguments):
    """Run a script that calls its last argument with its result."""
    return browser.execute_async_script(
        f"(async function () {{{script}}}).apply(null, arguments)", *arguments
    )


class LabTerminal:
    """A terminal in JupyterLab; it can do what guide_student.Terminal can."""

    def __init__(self, name, browser):
        self.name = name
        self.browser = browser
        run_async(browser, OPEN_TERMINAL, name)
        self.wait(lambda _: PROMPT.search(self.text), "the prompt")

    @property
    def text(self):
        return self.browser.execute_script(TEXT, self.name)

    @property
    def shown(self):
        """Its output since the last line was typed, which is the first one on the screen."""
        return self.text.partition("\n")[2]

    def wait(self, condition, what):
        return wait_until(
            lambda: condition(self.shown), f"no {what} in the terminal {self.name}:\n{self.text}"
        )

    def press(self, keys, clear=True):
        self.browser.execute_script(KEYBOARD, self.name, clear).send_keys(keys)

    def type(self, line):
        self.press(line + Keys.ENTER)

    def run(self, line):
        self.type(line)
        prompt = self.wait(PROMPT.search, f"the end of '{line}'")
        return int(prompt[1]), self.shown[: prompt.start()]

    def interrupt(self):
        self.press(Keys.CONTROL + "c")
        self.wait(PROMPT.search, "the prompt after Ctrl-C")

    def close(self):
        self.browser.execute_script("window.terminals[arguments[0]].dispose()", self.name)


class OtherDisplay(VirtualDisplay):
    """A display that another program has started."""

    def __init__(self, environment):
        self.environment = environment


class LabStudent(Student):
    """A student in front of JupyterLab."""

    def __init__(self, home, root):
        super().__init__(home)
        self.root = root
        self.browser = None
        del self.environment["LIBGL_ALWAYS_SOFTWARE"]
        (home / ".bashrc").write_text("PS1='[prompt:$?]'\n", encoding="utf-8")
        settings = home / ".jupyter"
        settings.mkdir()
        (settings / "jupyter_lab_config.json").write_text(
            '{"LabApp": {"expose_app_in_browser": true}}', encoding="utf-8"
        )

    def open_terminal(self, name):
        return LabTerminal(name, self.browser)

    def look_for_display(self):
        """Use the display on which the terminals open windows."""
        _, output = self.terminal("work").run("echo $DISPLAY $XAUTHORITY")
        display, authority = output.split()
        self.display = OtherDisplay(
            {**self.environment, "DISPLAY": display, "XAUTHORITY": authority}
        )

    def save(self, step, text):
        path = (self.workspace / "src" / step.file).resolve()
        name = str(path.relative_to(self.root))
        if not path.exists():
            run_async(self.browser, CREATE_FILE, name.rpartition("/")[0], name)
        elif step.todo:
            text = replaced(path.read_text(encoding="utf-8"), step.todo, text)
        page = run_async(self.browser, OPEN_FILE, name)
        page.send_keys(Keys.CONTROL + "a")
        self.browser.execute_script(PASTE, page, text)
        page.send_keys(Keys.CONTROL + "s")
        wait_until(
            lambda: self.browser.execute_script(SAVED) and path.read_text(encoding="utf-8") == text,
            f"{path} is saved",
        )
        self.browser.execute_script("window.editor.dispose()")
