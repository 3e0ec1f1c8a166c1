"""The road of the second graded drive: drawn from a seed, and with traffic that matters."""

from dataclasses import replace

import pytest

from sdc_experiments.closed_loop import drive
from sdc_package.car import MissionDriver
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.unknown_route import write_unknown_route, write_unseen_road


@pytest.mark.parametrize("write", [write_unknown_route, write_unseen_road])
def test_seed_alone_decides_about_road_and_traffic(tmp_path, write):
    texts = []
    for name, seed in (("a", 7), ("b", 7), ("c", 8)):
        (tmp_path / name).mkdir()
        texts.append([path.read_text() for path in write(seed, tmp_path / name)])
    assert texts[0] == texts[1]
    assert all(one != other for one, other in zip(texts[0], texts[2]))


def test_check_draws_a_new_road_and_a_grade_that_of_its_secret(tmp_path):
    def road(**more):
        return Stage(Student(tmp_path), **more).road_seed(second=False)

    assert road() != road() != road(seed="a") == road(seed="a")
    assert road(seed="a") != road(seed="a", secret="7") == road(seed="b", secret="7")
    assert road(secret="7") != Stage(Student(tmp_path), secret="7").road_seed(second=True) == 7


@pytest.mark.slow(4)
@pytest.mark.parametrize(
    "ignored, infraction",
    [
        ("", ""),
        ("light", "red_light"),
        ("car", "collision_vehicle"),
        ("pedestrian", "collision_pedestrian"),
    ],
)
def test_car_that_ignores_any_traffic_is_caught(tmp_path, monkeypatch, ignored, infraction):
    plan = MissionDriver.plan

    def blind(self, observation):
        lights = {} if ignored == "light" else observation.light_states
        kinds = [("car" if one.length_m > 2.0 else "pedestrian") for one in observation.obstacles]
        seen = [one for one, kind in zip(observation.obstacles, kinds) if kind != ignored]
        return plan(self, replace(observation, obstacles=seen, light_states=lights))

    monkeypatch.setattr(MissionDriver, "plan", blind)
    for seed in (2, 6):
        route, scenario = map(str, write_unknown_route(seed, tmp_path))
        report = drive(scenario, route=route)
        found = {name: count for name, count in report["infractions"].items() if count}
        assert found == ({infraction: 1} if infraction else {})
        assert (report["driving_score"] == 100.0) == (not ignored)
