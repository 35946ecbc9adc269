from __future__ import annotations

import subprocess
import sys

from server.http.problem_error import ProblemError


def test_a_problem_is_its_line_for_people() -> None:
    problem = ProblemError(404, "scene-not-found", "scene a: no such scene", field="scene")
    assert str(problem) == problem.detail == "scene a: no such scene"
    assert (problem.status, problem.code, problem.field, problem.headers) == (404, "scene-not-found", "scene", None)


def test_it_can_be_raised_without_a_web_library() -> None:
    program = "import sys, server.http.problem_error; sys.exit('fastapi' in sys.modules or 'starlette' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)
