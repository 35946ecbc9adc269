"""The bytes of a reconnection: to a scene that the client has whole, and to one that has grown by a segment since.

    python -m scripts.measure_reconnects --minutes 60

Prints the bytes of `hello`, and of the manifest's part of the answer.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable

from hgs_core.codec.format.growth import first_segments
from server.bench.bench_scene import made_up_scene
from server.protocol.messages import PROTOCOL_VERSION, Hello, encode
from server.scenes.scene_index import SceneIndex, read_scene
from server.stream.stream_session import ChunkPart, StreamSession

__all__: list[str] = []


def cost(scene: SceneIndex, hello: Hello) -> tuple[int, int]:
    """Return the bytes of a hello, and of the manifest's part of the answer: messages and pages."""
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


def everything(scene: SceneIndex) -> Hello:
    """Return the hello of a client that has all of a scene."""
    pages = dict(scene.page_chunks)
    last = list(pages)[-1:] if scene.live is not None else []
    listed = {name: bits(pages[name]) for name in pages if name not in last}
    rest = [chunk.id for chunk in scene.static] + [name for page in last for name in (page, *pages[page])]
    return Hello(
        PROTOCOL_VERSION,
        1 << 26,
        have=frozenset(rest),
        pages=listed,
        manifest_id=scene.manifest_id,
        follow=True,
    )


def bits(names: Iterable[bytes]) -> bytes:
    """Return a bit for each name."""
    return bytes([255] * (len(list(names)) // 8 + 1))


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
    for name, scene, known in (("unchanged", complete, complete), ("grown", after, before)):
        sent, received = cost(scene, everything(known))
        print(f"{name}: {sent} bytes of hello, {received} bytes of the manifest")


if __name__ == "__main__":
    main()
