"""How a scene becomes small chunks: what each splat shows, quantisation steps, motion orders, and layers."""

__all__: list[str] = []
