"""Work is found however it was handed in, and what is not found or not safe is one line."""

import os
import shutil
import zipfile

import pytest

from sdc_workshop.grading.handed_in import HandedInError, copy_workspace, names, submissions
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
        ("a/b/Work.7z", "7z", "Work.7z: neither a folder nor a zip that opens"),
        ("work.rar", "Rar!", "neither a folder nor a zip"),
        ("slip.zip", {"../../slip.py": ""}, "is no workspace: it has no src/sdc_package"),
        ("bomb.zip", {f"{n}.py": "0" * 20_000_000 for n in range(11)}, "is too large unpacked"),
        ("two.zip", {f"{n}/sdc_package/x": "" for n in "ab"}, "more than one sdc_package: a/"),
        ("deep.zip", {"a/" * 900 + "x": ""}, "folders in more than 60 levels"),
        ("below.zip", {"a/" * 20 + "src/sdc_package/x": ""}, "in its first 16 levels of folders"),
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


def test_zips_of_every_form_are_found_or_named(tmp_path, workspace):
    home = "Users/ada/Desktop/Uni/WS26/Robotik/Abgabe/final/sdc_ws/src/"
    packed(workspace / "src", tmp_path / "deep.zip", home)
    inside = tmp_path / "deep.zip"
    for name in ("once", "twice", "thrice"):
        with zipfile.ZipFile(tmp_path / f"{name}.zip", "w") as archive:
            archive.write(inside, "inside.zip")
        inside = tmp_path / f"{name}.zip"
    for name in ("deep", "once", "twice"):
        copy_workspace(tmp_path / f"{name}.zip", tmp_path / name / "copy")
        assert (tmp_path / name / "copy" / CAMERA).is_file()
    with pytest.raises(HandedInError, match="but zips in 3 zips; hand in one zip"):
        copy_workspace(tmp_path / "thrice.zip", tmp_path / "thrice" / "copy")
    (tmp_path / "two").mkdir()
    for name in ("Abgabe.zip", "Abgabe 2.zip"):
        shutil.copy(tmp_path / "deep.zip", tmp_path / "two" / name)
        (tmp_path / "two" / f"._{name}").touch()
    with pytest.raises(HandedInError, match="has 2 zips: Abgabe 2.zip, Abgabe.zip; keep one"):
        copy_workspace(tmp_path / "two", tmp_path / "both" / "copy")
    with zipfile.ZipFile(tmp_path / "lzma.zip", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("src/sdc_package/x.py", "x" * 1000)
    data = bytearray((tmp_path / "lzma.zip").read_bytes())
    data[60:75] = bytes(range(200, 215))
    (tmp_path / "lzma.zip").write_bytes(data)
    with pytest.raises(HandedInError, match="neither a folder nor a zip that opens"):
        copy_workspace(tmp_path / "lzma.zip", tmp_path / "lzma" / "copy")


@pytest.mark.slow(2)
def test_strange_files_of_an_older_workspace_are_copied_as_they_are(tmp_path, workspace):
    """The check of each file names what is wrong with it; the marker is not the student's."""
    package = workspace / "src/sdc_package"
    (workspace / ".workshop").write_bytes(b"\xfc older\n")
    (package / "config/local_planner.yaml").write_text("[" * 5000)
    latin = (workspace / CAMERA).read_bytes() + b"# \xfc\n"
    (workspace / CAMERA).write_bytes(latin)
    copy_workspace(workspace, tmp_path / "copy")
    assert (tmp_path / "copy" / CAMERA).read_bytes() == latin
    deep = package
    for _ in range(900):
        deep = deep / "a"
        os.mkdir(deep)
        if len(str(deep)) > 3900:
            break
    with pytest.raises(HandedInError, match="folders in more than 60 levels"):
        copy_workspace(workspace, tmp_path / "other")


def test_link_in_a_class_is_not_followed_and_a_name_is_one_line(tmp_path, workspace):
    (tmp_path / "class").mkdir()
    (tmp_path / "class" / "eve").symlink_to(workspace)
    (tmp_path / "class" / "x\ngrade: ada").mkdir()
    eve, other = found = submissions([tmp_path / "class"], tmp_path / "grades")
    assert names(found, ["eve"]) == {eve: "eve_", other: "x_grade_ ada"}
    with pytest.raises(HandedInError, match="is a link to another place"):
        copy_workspace(eve, tmp_path / "copy")
