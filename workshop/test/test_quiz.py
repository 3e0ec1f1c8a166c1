"""./workshop/check quiz: questions drawn from a seed, asked on standard input and graded."""

import io

import pytest

from sdc_workshop import progress, quiz
from sdc_workshop.check import main
from sdc_workshop.workspace import link


@pytest.mark.slow(3)
@pytest.mark.parametrize("lesson", quiz.lessons())
def test_lesson_has_five_questions_whose_answers_vary_with_the_seed(lesson):
    drawn = [quiz.questions(lesson, str(seed)) for seed in range(30)]
    assert {len(questions) for questions in drawn} == {5}
    for same in zip(*drawn):
        assert len({question.answer for question in same}) > 1, same[0].text
        assert all(len(set(question.choices)) == len(question.choices) for question in same)


def test_quiz_grades_answers_and_keeps_the_last_result(tmp_path, monkeypatch, capsys):
    def ask(*answers):
        monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{one}\n" for one in answers)))
        return main(["--seed", "7", "quiz", "phase-3"]), progress.quizzes(tmp_path)

    (tmp_path / "src/sdc_package").mkdir(parents=True)
    link(tmp_path)
    monkeypatch.setenv("PWD", str(tmp_path))
    drawn = quiz.questions("phase-3", "7")
    right = ["abcdefgh"[one.answer] if one.choices else one.answer for one in drawn]
    assert ask(*(str(one).replace(".", ",") for one in right)) == (0, {"phase-3": 5})
    assert ask("no number", 99.0, *right[1:]) == (1, {"phase-3": 4})
    assert f"No, it is {right[0]:g} (dot product)" in capsys.readouterr().out
    assert ask(*right[:2]) == (1, {"phase-3": 4})
    assert capsys.readouterr().out.endswith("ended at question 3 of 5; no result is kept.\n")
