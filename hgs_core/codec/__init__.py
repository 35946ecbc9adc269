"""Scenes as bytes: content-addressed chunks of quantised splats, and the manifest that lists them (docs/format.md)."""

from hgs_core.codec.encoder.encode import encode_scene
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.kept_splats import kept_chunks
from hgs_core.codec.encoder.scene_chunks import SceneChunks
from hgs_core.codec.encoder.utility import SetUtility, Utility
from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry, Totals
from hgs_core.codec.format.scene_folder import decode_scene, load_manifest, read_chunk

__all__ = [
    "ChunkEntry",
    "ChunkError",
    "DecodedChunk",
    "EncodeSettings",
    "Manifest",
    "SceneChunks",
    "SegmentEntry",
    "SetUtility",
    "SliceEntry",
    "Totals",
    "Utility",
    "decode_chunk",
    "decode_scene",
    "encode_scene",
    "kept_chunks",
    "load_manifest",
    "read_chunk",
]
