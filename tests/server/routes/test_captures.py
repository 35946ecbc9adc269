from __future__ import annotations

import json
from typing import Any


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
