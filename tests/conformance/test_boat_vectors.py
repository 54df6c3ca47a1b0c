"""The example session of the original and the cases of the specification, played into the machine."""

import pytest

from tests.conformance.transcript import Step, cases, play, steps
from tests.recordings import vectors


def test_the_example_session_of_the_original_is_reproduced():
    play(steps(vectors("boat_session.jsonl")))


@pytest.mark.parametrize("case", cases(vectors("boat_command_cases.jsonl")), ids=lambda case: case["name"])
def test_the_case_of_the_specification_holds(case: Step):
    play(case["steps"])
