"""Scenes as bytes: content-addressed chunks of quantised splats, and the manifest that lists them (docs/format.md)."""

from hgs_core.codec.decode import DecodedChunk, decode_chunk
from hgs_core.codec.encode import encode_scene
from hgs_core.codec.errors import ChunkError
from hgs_core.codec.folder import decode_scene, load_manifest, read_chunk
from hgs_core.codec.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry, Totals
from hgs_core.codec.settings import EncodeSettings
from hgs_core.codec.weights import SetUtility, Utility

__all__ = [
    "ChunkEntry",
    "ChunkError",
    "DecodedChunk",
    "EncodeSettings",
    "Manifest",
    "SegmentEntry",
    "SetUtility",
    "SliceEntry",
    "Totals",
    "Utility",
    "decode_chunk",
    "decode_scene",
    "encode_scene",
    "load_manifest",
    "read_chunk",
]
