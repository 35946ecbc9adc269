"""Run folders of jobs: places, saving, reading, removal, readiness."""

__all__: list[str] = []
