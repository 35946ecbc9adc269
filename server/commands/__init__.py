"""The subcommands of `hgs`: one module each, with `add_parser` and what it runs; heavy imports wait until then."""

__all__: list[str] = []
