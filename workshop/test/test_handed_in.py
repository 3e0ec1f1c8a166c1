"""Work is found however it was handed in, and what is not found or not safe is one line."""

import os
import shutil
import zipfile

import pytest

from sdc_workshop.grading.copying import copy_workspace
from sdc_workshop.grading.handed_in import HandedInError, names, submissions
from sdc_workshop.workspace import make

CAMERA = "src/sdc_package/scripts/camera.py"


@pytest.fixture
def workspace(tmp_path):
    make(tmp_path / "made")
    (tmp_path / "made" / CAMERA).chmod(0o755)
    # What an update and a build leave is not a second package.
    for name in ("before_update_x", "build", "devel/share"):
        shutil.copytree(tmp_path / "made/src/sdc_package", tmp_path / "made" / name / "sdc_package")
    return tmp_path / "made"


def packed(folder, path, prefix=""):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as file:
        for one in sorted(folder.rglob("*")):
            file.write(one, f"{prefix}{one.relative_to(folder)}")


@pytest.mark.slow(3)
def test_every_form_of_handing_in_is_found(tmp_path, workspace):
    students = tmp_path / "class"
    copy = lambda source, name: shutil.copytree(source, students / name, symlinks=True)  # noqa: E731
    copy(workspace, "ada/sdc_ws")
    copy(workspace, "bert")
    copy(workspace / "src", "cleo")
    copy(workspace / "src/sdc_package", "dora")
    copy(workspace, "emil/my work/sdc_ws")
    packed(workspace, students / "fred.zip", "sdc_ws/")
    packed(workspace / "src/sdc_package", students / "Gina G_12_assignsubmission_file_/all.zip")
    packed(workspace / "src", students / "huhu_LATE_345_678_work.zip")
    found = names(submissions([students], students / "grades"))
    known = ["Gina G", "ada", "bert", "cleo", "dora", "emil", "fred", "huhu"]
    assert list(found.values()) == known
    for path, name in found.items():
        copy_workspace(path, tmp_path / name / "copy")
        assert os.access(tmp_path / name / "copy" / CAMERA, os.X_OK), name


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    "path, content, message",
    [
        ("empty/x.txt", "", "is no workspace: it has no src/sdc_package"),
        ("work.rar", "Rar!", "neither a folder nor a zip"),
        ("slip.zip", {"../../slip.py": ""}, "is no workspace: it has no src/sdc_package"),
        ("bomb.zip", {f"{n}.py": "0" * 20_000_000 for n in range(11)}, "is too large unpacked"),
        ("two.zip", {f"{n}/sdc_package/x": "" for n in "ab"}, "more than one sdc_package: a/"),
    ],
)
def test_what_is_not_found_or_not_safe_is_a_row_with_one_line(tmp_path, path, content, message):
    file = tmp_path / "class" / path
    file.parent.mkdir(parents=True)
    if isinstance(content, str):
        file.write_text(content)
    else:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, text in content.items():
                archive.writestr(name, text)
    (found,) = submissions([tmp_path / "class"], tmp_path / "grades")
    with pytest.raises(HandedInError) as caught:
        copy_workspace(found, tmp_path / "copy" / "workspace")
    assert message in str(caught.value) and "\n" not in str(caught.value)
    unpacked = tmp_path / "copy" / "handed_in"
    assert [path for path in tmp_path.rglob("slip.py") if unpacked not in path.parents] == []


def test_link_in_a_class_is_not_followed_and_a_name_is_one_line(tmp_path, workspace):
    (tmp_path / "class").mkdir()
    (tmp_path / "class" / "eve").symlink_to(workspace)
    (tmp_path / "class" / "x\ngrade: ada").mkdir()
    eve, other = found = submissions([tmp_path / "class"], tmp_path / "grades")
    assert names(found, ["eve"]) == {eve: "eve_", other: "x_grade_ ada"}
    with pytest.raises(HandedInError, match="is a link to another place"):
        copy_workspace(eve, tmp_path / "copy")
