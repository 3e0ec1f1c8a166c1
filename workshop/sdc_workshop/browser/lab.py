"""./workshop/browser: JupyterLab with the guide, terminals, editor, cockpit and desktop."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from sdc_cockpit.access import new_token
from sdc_experiments.commands import parse
from sdc_workshop import languages, progress
from sdc_workshop.browser import desktop, service
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import PROJECT

# Outside the ports that the cockpits of ./drive take.
COCKPIT_PORT = 8480
_PYTHON = PROJECT / ".browser" / "bin" / "python"
# Programs in the terminals print their pages below this address, with the same token.
URL_VARIABLE = "WORKSHOP_URL"
_CONFIGURATION = Path(__file__).with_name("lab.yaml")


def local_guide(cockpit: str, workspace: Path) -> Path:
    """Return the path of a guide, in the reader's language, with the real path of the project.

    Its pages are beside the English ones, because their links are relative: "Workshop.md", ... The
    buttons open `cockpit`, a URL with the token, and the next step of the workspace.
    """
    first = languages.GUIDE[0]
    try:
        for name in languages.GUIDE:
            text = languages.page(name).replace("~/workshop", str(PROJECT))
            for other in languages.GUIDE:
                text = text.replace(f"]({other}", f"](<{_local(other)}>")
            if name == first:
                title, _, rest = text.partition("\n")
                text = f"{title}\n\n{_buttons(cockpit, workspace)}\n{rest}"
            file = languages.FOLDER / _local(name)
            file.touch(mode=0o600)
            file.write_text(text, encoding="utf-8")
    except OSError:
        # The project of another user; the guide says how to read its commands.
        return languages.FOLDER / languages.language() / first
    return languages.FOLDER / _local(first)


def _local(name: str) -> str:
    """Return the name of a page, which is the title of its tab."""
    return name.replace("guide", "Workshop").replace("phase-", "Phase ")


def _buttons(cockpit: str, workspace: Path) -> str:
    kept = progress.statuses(workspace)
    targets = {"Watch a drive": f"{cockpit}&drive", "Cockpit": cockpit}
    for step in load_steps():
        if kept.get(step.id) != PASSED:
            targets[f"Next step: {step.title}"] = f"<{_local(f'phase-{step.phase}.md')}>"
            break
    return " ".join(f"[<kbd>{label}</kbd>]({target})" for label, target in targets.items())


def layout(root: Path, workspace: Path, guide: Path) -> str:
    """Return JupyterLab's first layout, as JSON: the guide, and the files of the workspace.

    JupyterLab shows the folder `root`, which contains both. The workspace may not exist yet.
    """
    text = json.dumps(yaml.safe_load(_CONFIGURATION.read_text(encoding="utf-8"))["layout"])
    files = workspace if workspace.is_dir() else workspace.parent
    for name, path in (("<guide>", guide), ("<files>", files)):
        text = text.replace(name, json.dumps(str(path.relative_to(root)))[1:-1])
    return text


def write_configuration(
    folder: Path,
    root: Path,
    options: Mapping[str, object],
    given_token: str,
    proxied: Mapping[str, object],
) -> None:
    """Write the files that JupyterLab reads from `folder`, one of JUPYTER_CONFIG_PATH.

    It shows the files in `root`. The options are address and port; `proxied` are the other servers
    by the first part of their path.
    """
    values = yaml.safe_load(_CONFIGURATION.read_text(encoding="utf-8"))
    server = values["server"]
    server["ServerApp"].update(options, root_dir=str(root))
    server["IdentityProvider"]["token"] = given_token
    server["ServerProxy"] = {"servers": proxied}
    # Copies of opened files are by default beside them, in the project and the workspace.
    # Where that is not possible, as in a folder that does not exist, they are in TMPDIR.
    server["FileCheckpoints"] = {"root_dir": str(root / "nonexistent")}
    file = folder / "jupyter_server_config.json"
    file.touch(mode=0o600)
    file.write_text(json.dumps(server), encoding="utf-8")
    settings = folder / "labconfig" / "default_setting_overrides.json"
    settings.parent.mkdir()
    settings.write_text(json.dumps(values["settings"]), encoding="utf-8")


def proxy(title: str, port: int, given_token: str) -> dict:
    """Return the entry of a server on this machine: a tile that opens it in a tab of JupyterLab.

    Jupyter has checked host and origin of a request. The server then sees its own.
    """
    own = f"127.0.0.1:{port}"
    name = title.lower()
    return {
        "port": port,
        "new_browser_tab": False,
        "request_headers_override": {"Host": own, "Origin": f"http://{own}"},
        "launcher_entry": {
            "title": title,
            "path_info": f"{name}/?token={given_token}",
            "icon_path": str(Path(__file__).with_name(f"{name}.svg")),
            "category": "Other",
        },
    }


def _workspace(text: str) -> Path:
    folder = Path(text).absolute()
    if folder.exists() and not folder.is_dir():
        raise service.ServiceError(f"{folder} is a file; name the folder of your workspace")
    if not folder.parent.is_dir():
        raise service.ServiceError(
            f"{folder.parent} does not exist; create it, or name another workspace"
        )
    return folder


def main(arguments: Sequence[str]) -> None:
    """Serve JupyterLab until Ctrl-C."""
    with service.errors_in_one_line("browser"), tempfile.TemporaryDirectory() as name:
        options = parse("workshop/browser", arguments)
        folder = Path(name)
        with service.Programs(folder / "log") as programs:
            workspace = _workspace(os.path.expanduser(options.workspace))
            port = service.free_port(options.ip, options.port)
            given_token = new_token()
            root = Path(os.path.commonpath([workspace.parent, PROJECT]))
            cockpit_port = service.free_port("127.0.0.1", COCKPIT_PORT)
            proxied = {
                "cockpit": {
                    **proxy("Cockpit", cockpit_port, given_token),
                    # It starts when its page is first opened. TMPDIR is for JupyterLab only.
                    "command": ["setpriv", "--pdeathsig", "TERM", "env", "-u", "TMPDIR"]
                    + [str(PROJECT / "cockpit"), f"port:={cockpit_port}"]
                    + [f"drives_folder:={workspace.parent / 'drives'}"],
                    "timeout": 120,
                }
            }
            environment = {
                **os.environ,
                "JUPYTER_CONFIG_PATH": str(folder / "jupyter"),
                URL_VARIABLE: service.url(options.ip, port, ""),
                service.TOKEN_VARIABLE: given_token,
            }
            if "DISPLAY" not in environment and shutil.which("Xtigervnc"):
                (folder / "desktop").mkdir()
                desktop_port = service.free_port("127.0.0.1", desktop.PORT)
                environment = desktop.Desktop(programs, folder / "desktop").start(
                    environment, "127.0.0.1", desktop_port, given_token
                )
                proxied["desktop"] = proxy("Desktop", desktop_port, given_token)
            (folder / "jupyter").mkdir()
            listen = {"ip": options.ip, "port": port}
            write_configuration(folder / "jupyter", root, listen, given_token, proxied)
            environment.update(TMPDIR=name, JUPYTERLAB_WORKSPACES_DIR=str(folder / "layouts"))
            cockpit = service.url(options.ip, port, f"cockpit/?token={given_token}")
            guide = local_guide(cockpit, workspace)
            (folder / "layout.json").write_text(layout(root, workspace, guide))
            command = [str(_PYTHON), "-m", "jupyterlab"]
            subprocess.run(
                [*command, "workspaces", "import", folder / "layout.json"],
                env=environment,
                check=True,
                capture_output=True,
            )
            process = programs.start(command, environment, cwd=workspace.parent)
            programs.wait_for_port(process, options.ip, port)
            page = service.url(options.ip, port, f"lab?token={given_token}")
            service.announce("browser", page, options.ip)
            programs.wait()


if __name__ == "__main__":
    main(sys.argv[1:])
