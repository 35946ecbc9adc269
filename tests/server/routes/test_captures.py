from __future__ import annotations

import json
from typing import Any

from tests.synthetic import write_capture


def test_captures_are_listed_as_a_job_names_them(server: Any) -> None:
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    left = {"file_path": "left.png", "transform_matrix": pose}
    transforms = {"fl_x": 50, "w": 64, "h": 48, "frames": [left]}
    (server.captures / "studio" / "transforms.json").write_text(json.dumps(transforms))
    (server.captures / "studio" / "left.png").touch()
    listed = server.get("/v1/captures")
    assert listed.status_code == 200
    (capture,) = listed.json()["captures"]
    assert (capture["name"], capture["layout"], capture["cameras"]) == ("studio", "nerfstudio, instant-ngp", ["left"])
    submitted = server.request("POST", "/v1/jobs", json={"capture": capture["capture"]})
    assert submitted.status_code == 201
    assert server.get("/v1/captures", If_None_Match=listed.headers["etag"]).status_code == 304


def test_each_camera_of_a_capture_has_a_picture_that_browsers_keep(server: Any) -> None:
    write_capture(server.captures / "studio", frames=2)
    told = server.get("/v1/captures/pictures?capture=studio")
    assert told.status_code == 200
    pictures = told.json()["pictures"]
    assert len(pictures) > 2
    assert all(one.startswith("data:image/jpeg;base64,") for one in pictures.values())
    assert server.get("/v1/captures/pictures?capture=studio", If_None_Match=told.headers["etag"]).status_code == 304


def test_a_capture_that_is_none_has_no_pictures(server: Any) -> None:
    answer = server.get("/v1/captures/pictures?capture=studio")
    assert (answer.status_code, answer.json()["code"], answer.json()["field"]) == (422, "capture-invalid", "capture")
    assert server.get("/v1/captures/pictures?capture=/etc").status_code == 403
