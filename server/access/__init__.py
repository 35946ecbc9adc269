"""Access control: keys, links, visitors, hosts."""

__all__: list[str] = []
