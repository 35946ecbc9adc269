"""What a client pays that comes back to a scene of which it has all, and to one that has grown by a segment since.

    python -m scripts.measure_reconnects --minutes 60

Tells, for versions 2 and 3 of the protocol, the bytes of what `hello` has, and of what then comes of the manifest.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable

from hgs_core.codec.format.growth import first_segments
from server.bench.bench_scene import made_up_scene
from server.protocol.messages import MAX_HAVE, Hello, encode
from server.scenes.scene_index import SceneIndex, read_scene
from server.stream.stream_session import ChunkPart, StreamSession

__all__: list[str] = []


def cost(scene: SceneIndex, hello: Hello) -> tuple[int, int]:
    """Return the bytes of a hello, and of what the server sends of the manifest for it: messages and pages."""
    session = StreamSession(scene)
    greeting = encode(hello)
    session.receive(greeting, 0.0)
    received = 0
    while (item := session.take(0.0)) is not None:
        if isinstance(item, ChunkPart):
            received += item.length if item.data is not None else 0
        elif not item.startswith(b"\x85\xa4type\xa5slice"):
            received += len(item)
    return len(greeting), received


def everything(scene: SceneIndex, version: int) -> Hello:
    """Return the hello of a client that has all of a scene."""
    if version < 3:
        scene = scene.whole
        if scene.live is not None:
            return hello(version, scene, have=frozenset(list(scene.sizes)[-MAX_HAVE:]))
        return hello(version, scene, have_bits=b"\xff" * (len(scene.sizes) // 8 + 1))
    pages = dict(scene.page_chunks)
    last = list(pages)[-1:] if scene.live is not None else []
    listed = {name: bits(pages[name]) for name in pages if name not in last}
    rest = [chunk.id for chunk in scene.static] + [name for page in last for name in (page, *pages[page])]
    return hello(version, scene, have=frozenset(rest), pages=listed)


def bits(names: Iterable[bytes]) -> bytes:
    """Return a bit for each name."""
    return bytes([255] * (len(list(names)) // 8 + 1))


def hello(version: int, scene: SceneIndex, **fields: object) -> Hello:
    """Return a hello of a client that follows, and has room for all."""
    return Hello(version, 1 << 26, manifest_id=scene.manifest_id, follow=True, codings=("gzip",), **fields)  # type: ignore[arg-type]


def main() -> None:
    """Print a line for each case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=int, default=60)
    seconds = 60 * parser.parse_args().minutes
    manifest = made_up_scene(seconds, static_bytes=1200, slice_bytes=90).manifest
    count = len(manifest.segments)
    versions = [first_segments(manifest, number) for number in (count - 2, count - 1)]
    before, after = (read_scene("bench", json.dumps(one.to_json()).encode()) for one in versions)
    complete = read_scene("bench", json.dumps(manifest.to_json()).encode())
    for version in (2, 3):
        for name, scene, known in (("unchanged", complete, complete), ("grown", after, before)):
            sent, received = cost(scene, everything(known, version))
            print(f"version {version}, {name}: {sent} bytes of hello, {received} bytes of the manifest come")


if __name__ == "__main__":
    main()
