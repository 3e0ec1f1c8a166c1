import pickle

import numpy as np
import pytest

pytest.importorskip("torch", reason="torch is not installed (docker/prepare imitation)")

from sdc_perception.imitation_network import SteeringNetwork, build_network

VIEW = np.random.default_rng(0).integers(0, 255, (40, 128, 3), dtype=np.uint8)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "network.npz"
    network = SteeringNetwork(build_network())
    network.save(str(path))
    return network, path


def test_loaded_network_answers_as_the_saved_one(saved):
    network, path = saved
    assert SteeringNetwork.load(str(path)).answer(VIEW) == network.answer(VIEW)
    other = VIEW.copy()
    other[:, 60:] = 0
    assert network.answer(other) != network.answer(VIEW)


class Boom:
    def __reduce__(self):
        return exec, ("raise SystemExit('the file ran code')",)


def changed(path, **changes):
    with np.load(path) as file:
        entries = {**file, **changes}
    with open(path, "wb") as file:
        np.savez(file, **{name: value for name, value in entries.items() if value is not None})


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda path: path.unlink(), "there is no such file"),
        (lambda path: path.write_bytes(b""), "is not a steering network"),
        (lambda path: path.write_text("hello"), "is not a steering network"),
        (lambda path: path.write_bytes(path.read_bytes()[:5000]), "is not a steering network"),
        (lambda path: path.write_bytes(pickle.dumps(Boom())), "is not a steering network"),
        (lambda path: changed(path, format=None), "no entry 'format'"),
        (lambda path: changed(path, format=np.array([Boom()])), "is not a steering network"),
        (lambda path: changed(path, **{"0.bias": None}), "the weights '0.bias' are missing"),
        (lambda path: changed(path, **{"0.bias": np.zeros(3, np.float32)}), "of another size"),
        (lambda path: changed(path, **{"0.bias": np.full(16, np.nan, np.float32)}), "not finite"),
    ],
)
def test_bad_file_is_refused_in_one_line(saved, damage, problem):
    _, path = saved
    damage(path)
    with pytest.raises(ValueError) as refused:
        SteeringNetwork.load(str(path))
    text = str(refused.value)
    assert text.startswith(f"{path}: ")
    assert problem in text
    assert "sdc_perception.imitation.train" in text
    assert "\n" not in text
