"""Check all steps of one workspace, and write the answers after each step.

So the answers are kept when the check is ended before its end.
Usage: python3 -m sdc_workshop.grading.examine_one WORKSPACE RESULT_FOLDER
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

from sdc_workshop.exam.answer import Answer
from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.steps import Step, load_steps

ANSWERS = "answers.json"


def main() -> None:
    """Write RESULT_FOLDER/answers.json, and the referee's report next to it."""
    workspace, result = Path(sys.argv[1]), Path(sys.argv[2])
    answers = {}
    student = Student(workspace)
    with Stage(student) as stage:
        examination = Examination(student, stage, drive_anyway=True)

        def save(step: Step, answer: Answer) -> None:
            answers[step.id] = answer.as_dict()
            part = result / f"{ANSWERS}.part"
            part.write_text(json.dumps(answers, indent=1) + "\n", encoding="utf-8")
            os.replace(part, result / ANSWERS)

        examination.judge(load_steps(), save)
        for path in sorted((stage.folder / "report").glob("report*")):
            if path.is_file():
                shutil.copyfile(path, result / path.name)


if __name__ == "__main__":
    main()
