"""Scenes as bytes: content-addressed chunks of quantised splats, and the manifest that lists them (docs/format.md)."""

from hgs_core.codec.encoder.encode import encode_scene
from hgs_core.codec.encoder.settings import EncodeSettings
from hgs_core.codec.encoder.utility import SetUtility, Utility
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.errors import ChunkError
from hgs_core.codec.format.folder import decode_scene, load_manifest, read_chunk
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry, Totals

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
