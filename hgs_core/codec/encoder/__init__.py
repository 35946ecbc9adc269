"""The encoder of scenes into small chunks: utility of splats, quantisation steps, motion orders, and layers."""

__all__: list[str] = []
