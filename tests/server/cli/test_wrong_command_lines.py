"""Command lines that cannot be right, over every command: one line, status 2, nothing written, never a traceback."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from server.cli import main

# {run} a finished run, {capture} a capture, {splats} a file of splats, {junk} a file of random bytes, {empty} an empty
# folder, {file} an empty file, {none} nothing, {out} a place that can be written, {dead} a server that nobody runs.
LINES = """
view
trian {capture} --out {out}
--presett
train
train {capture}
train --out {out}
train {none} --out {out}
train {file} --out {out}
train {junk} --out {out}
train {empty} --out {out}
train '' --out {out}
train {capture} --out ''
train {capture} --out {file}
train {capture} --out {capture}
train {capture} --out {out} --preset bst
train {capture} --out {out} --presett best
train {capture} --out {out} --set train.iteration=3
train {capture} --out {out} --set train.iterations=NaN
train {capture} --out {out} --set train.iterations=-5
train {capture} --out {out} --set train.iterations=1e400
train {capture} --out {out} --set train.iterations=99999999999999999999999
train {capture} --out {out} --set train.iterations=2.5
train {capture} --out {out} --set train.iterations=many
train {capture} --out {out} --set train=3
train {capture} --out {out} --set train.iterations
train {capture} --out {out} --set =3
train {capture} --out {out} --set ''
train {capture} --out {out} --set
train {capture} --out {out} --set nothing.at.all=1
train {capture} --out {out} --downscale nan
train {capture} --out {out} --downscale -2
train {capture} --out {out} --downscale 0
train {capture} --out {out} --downscale 1,2
train {capture} --out {out} --downscale 100000
train {capture} --out {out} --downscale cam77=2
train {capture} --out {out} --hold-out cam77
train {capture} --out {out} --hold-out 0,1,2,3,4,5
train {capture} --out {out} --masks {none}
train {capture} --out {out} --masks {file}
train {capture} --out {out} --audio {none}
train {capture} --out {out} --audio {junk}
train {capture} --out {out} --audio camera:77
train {capture} --out {out} --audio ''
train {capture} --out {out}\0
jobs show x\udcff
submit {capture} --title x\udcff
keys add x\udcff
train {capture} --out {out} --sync sound
train {capture} {capture} --out {out}
check
check {none}
check {junk}
check {empty}
check {capture} --masks {none}
check {capture} --json {none}/x.json
check {capture} --json {empty}
check {capture} --json ''
cameras
cameras {none}
cameras {file}
cameras {empty}
cameras {capture}
cameras {empty} --focal nan
cameras {empty} --focal -3
cameras {empty} --focal inf
cameras {empty} --distance a
cameras {empty} --distance a,b=nan
cameras {empty} --board 8
cameras {empty} --board 8x5
cameras {empty} --board 8x5 --square nan
cameras {empty} --board 8x5 --square -1
cameras {empty} --board 0x0 --square 0.1
cameras {empty} --board 99999999x99999999 --square 0.1
cameras {empty} --board 8x5 --square 0.1 --dictionary what
cameras {empty} --square 0.1
sync
sync {none}
sync {junk}
sync {empty}
sync {capture}
sync {capture} --by smell
sync {empty} --out {file}
sync {none} --out {out}
masks
masks {capture}
masks {none} --out {out}
masks {junk} --out {out}
masks {capture} --out {capture}
masks {capture} --out {file}
masks {capture} --out {out} --sam {none}
encode
encode {none}
encode {file}
encode {capture}
encode {run} --budget huge
encode {run} --fine-tune -1
encode {run} --fine-tune 1.5
encode {run} --fine-tune 99999999999999999999
eval
eval {none}
eval {junk}
eval {empty}
eval {run} --cameras ''
eval {run} --cameras 77
eval {run} --cameras 1 --all-cameras
eval {run} --truth {none}
eval {run} --masks {none}
eval {run} --lpips {none}
eval {run} --lpips {junk}
eval {run} --lpips {empty}
eval {run} --backend gpu
report
report {none}
report {capture}
report {run} --out {empty}
report {run} --against {none}
report {run} --against
render
render {run} --out {out}.avi
render {run} --out {out}.mp4 --size 3x3
render {run} --out {out}.mp4 --fps 1/0
render {run} --out {out}.mp4 --path {junk}
render {run} --out {file}/x.mp4
render {none} --out {out}.mp4
backup {file}
restore {junk}
restore {none}
edit
edit {run}
edit {run} --out {out}
edit {none} --out {out} --trim=0,1
edit {run} --out {run} --trim=0,1
edit {run} --out {out} --scale 1e300
edit {run} --out {out} --translate=0,1e20,0
edit {run} --out {out} --trim=1
edit {run} --out {out} --trim=nan,1
edit {run} --out {out} --trim=3,4
edit {run} --out {out} --trim=0.1,0
edit {run} --out {out} --box=1,2,3
edit {run} --out {out} --box=0,0,0,-1,1,1
edit {run} --out {out} --box=0,0,0,1e400,1,1
edit {run} --out {out} --box=900,900,900,1,1,1
edit {run} --out {out} --sphere=0,0,0,0
edit {run} --out {out} --sphere=0,0,0
edit {run} --out {out} --inverse
edit {run} --out {out} --touching
edit {run} --out {out} --up=0,0,0
edit {run} --out {out} --rotate=0,0,0,90
edit {run} --out {out} --scale=0
edit {run} --out {out} --scale=-1
edit {run} --out {out} --scale=inf
edit {run} --out {out} --translate=1
edit {run} --out {out} --merge {none}
edit {run} --out {out} --at=1
edit {run} --out {out} --trim=0,0.1 --json {none}/x.json
publish
publish {none}
publish {capture}
publish {empty}
publish {run} --id 'A B'
publish {run} --id ../x
publish {run} --replace
publish {run} --data-only
publish {run} --to {junk}
publish {run} --to {out} --id x
publish {run} --to {capture}
publish {run} --to http://127.0.0.1:9/x
publish {run} --to gopher://x/y
publish {run} --to s3://
publish {run} --to ''
publish {run} --audio {none}
import
import {splats}
import {none} --out {out}
import {none}.ply --out {out}
import {junk} --out {out}
import {junk}.ply --out {out}
import {junk}.splat --out {out}
import {junk}.spz --out {out}
import {junk}.glb --out {out}
import {junk}.4dgs --out {out}
import {file} --out {out}
import {empty} --out {out}
import {splats} --out {capture}
import {splats} --out {out} --duration nan
import {splats} --out {out} --duration -1
import {splats} --out {out} --fps 30
import {empty} --out {out} --fps 0
import {splats} --out {out} --hold-out 1
import {splats} --out {out} --capture {none}
import {splats} --out {out} --budget none
export
export {run}
export {none} --to {out}.ply
export {capture} --to {out}.ply
export {run} --to {out}.docx
export {run} --to {out}.PDF
export {run} --to {out}.ply --time nan
export {run} --to {out}.ply --time 99
export {run} --to {out}.ply --segment 7
export {run} --to {out}.ply --segment -1
export {run} --to {out}.ply --fps 30
export {run} --to {out} --fps 0
export {run} --to {out} --fps -1
export {run} --to {out} --fps 1e9
export {run} --to {out}.spz --spz-version 9
export {run} --to {out}.ply --spz-version 3
export {run} --to ''
serve --port x
serve --port -1 --workers 0
serve --port 99999999 --workers 0
serve --port 0 --workers -1
serve --port 0 --workers x
serve --port 0 --drain nan
serve --port 0 --drain -1
serve --port 0 --max-streams 0
serve --port 0 --connections-per-address 0
serve --port 0 --workers 0 --host no.such.host.invalid
serve --port 0 --workers 0 --host ''
serve --port 0 --workers 0 --uploads quota=x
serve --port 0 --workers 0 --captures {none}
serve --port 0 --workers 0 --allow-host 'a b'
serve --port 0 --workers 0 --allow-origin nonsense
serve {none} --port 0 --workers 0
serve {capture} --port 0 --workers 0
serve {junk} --port 0 --workers 0
play
play x
play http://127.0.0.1:9/ --stats --patience 0
play http://127.0.0.1:9/view/x --stats --patience 0
play ws://127.0.0.1:9/v1/scenes/x/stream --stats --patience 0
play ws:// --stats
play http://[::1/view/x --stats
play http://127.0.0.1:9/view/x
play http://127.0.0.1:9/view/x --stats --patience -1
play http://127.0.0.1:9/view/x --stats --patience nan
play ''
play http://127.0.0.1:9/view/x --seconds nan --stats --patience 0
play http://127.0.0.1:9/view/x --seconds -1 --stats --patience 0
play http://127.0.0.1:99999999/view/x --stats --patience 0
submit
submit {none}
submit {junk}
submit {empty}
submit ''
submit {capture} --priority high
submit {capture} --priority 1000
submit {capture} --time-limit soon
submit {capture} --time-limit -1h
submit {capture} --webhook nonsense
submit {capture} --webhook ftp://x
submit {capture} --label ''
submit {capture} --set train.iteration=1
submit {capture} --to nonsense
submit {capture} --to ''
submit {capture} --to ftp://x
submit {capture} --to http://host:99999999
submit {capture} --to {dead} --masks {empty}
submit {capture} --to {dead} --audio {junk}
submit {none} --to {dead}
submit {capture} --to {dead} --patience 0
submit {capture} --to {dead} --patience -1
submit {capture} --to {dead} --patience 1e9
submit {capture} --patience soon
submit {junk} --to {dead}
jobs
jobs sl
jobs ls --state done
jobs ls --limit 0
jobs ls --limit x
jobs ls --since yesterday
jobs ls --to nonsense
jobs ls --to ''
jobs ls --to {dead} --patience 0
jobs ls --to http://a..b
jobs ls --to http://[::1
jobs ls --to 'http://a b/'
jobs ls --to http://127.0.0.1:0
jobs show x --to {dead} --patience 0
jobs delete x --to {dead} --patience 0
jobs workers --to {dead} --patience 0
jobs show
jobs show nothing
jobs show ''
jobs show ../../etc
jobs watch nothing
jobs logs nothing
jobs logs nothing --lines 0
jobs logs nothing --lines 100000
jobs cancel
jobs cancel nothing
jobs retry nothing
jobs delete nothing
worker {capture}
gc --keep-jobs x
gc --keep-jobs -1
gc --keep-days nan
gc --keep-bytes 5Q
gc --every soon
keys
keys add
keys add ''
keys add x --scope all
keys add x --for ever
keys add x --for 0d
keys add x --for 999999999d
keys revoke nobody
keys link nothing
keys link nothing --for x
bench
bench rester
bench raster --sizes x
bench raster --sizes 0@0x0
bench raster --sizes 1e30@10x10
bench raster --threads 0
bench raster --threads x
bench raster --backends gpu
bench raster --seconds nan
bench raster --seconds -1
bench raster --seconds inf
bench raster --dynamic 2
bench raster --dynamic nan
bench raster --seed -1
bench raster --json {none}/x.json
bench codec
bench codec {none}
bench codec {junk}
bench codec {capture}
bench codec {run} --sweep x
bench codec {run} --sweep nan
bench codec {run} --sweep -1
bench codec {run} --sweep 0
bench train
bench train {none}
bench train {capture} --device tpu
bench viewer {none}
bench viewer {run} --rounds x
bench viewer {run} --rounds 0
bench viewer {run} --frames 0
bench viewer {run} --size 3
bench viewer {run} --size 0x0
bench viewer {run} --viewers netscape
bench stream {none}
bench stream {junk}
bench stream --seconds nan
bench stream --seconds 0
bench stream --minutes nan
bench stream --minutes 1e9
bench serve --viewers 0
bench serve --processes 0
bench serve --seconds inf
bench serve {capture}
ablate
ablate {capture}
ablate {none} --out {out}
ablate {capture} --out {file}
ablate {capture} --out {out} --hold-out 1 --rows nothing
ablate {capture} --out {out} --hold-out 1 --rows ''
ablate {capture} --out {out} --hold-out 1 --seeds x
ablate {capture} --out {out} --hold-out 1 --seeds -1
ablate {capture} --out {out} --hold-out 1 --masks {none}
ablate {capture} --out {out} --hold-out 1 --truth {none}
ablate {capture} --out {out} --hold-out 1 --score-masks {none}
ablate {capture} --out {out}
""".strip().splitlines()


@pytest.fixture
def places(capture: Path, splats: Path, run: Path, tmp_path: Path) -> dict[str, Path | str]:
    folder = tmp_path / "places"
    (folder / "empty").mkdir(parents=True)
    (folder / "file").touch()
    junk = bytes(range(256)) * 16
    for suffix in ("", ".ply", ".splat", ".spz", ".glb", ".4dgs"):
        (folder / f"junk{suffix}").write_bytes(junk[1:])
    names = {name: folder / name for name in ("empty", "file", "junk", "none", "out")}
    return names | {"capture": capture, "splats": splats, "run": run, "dead": "http://127.0.0.1:9"}


def tree(*folders: Path) -> list[Path]:
    return sorted(path for folder in folders for path in folder.rglob("*") if path.name != "run.lock")


@pytest.mark.parametrize("line", LINES)
def test_a_wrong_command_line_is_refused_in_one_line(
    line: str,
    places: dict[str, Path],
    capture: Path,
    run: Path,
    home: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    before = tree(tmp_path / "places", capture, run)
    words = shlex.split(line.replace("\\0", "\0").replace("\\udcff", "\udcff").format(**places))
    assert status_of(lambda: main(words)) == 2
    told = capsys.readouterr()
    assert told.out == ""
    lines = [one for one in told.err.splitlines() if one.startswith("hgs: ")]
    assert len(lines) == 1, told.err
    assert len(told.err.splitlines()) <= 3, told.err
    assert tree(tmp_path / "places", capture, run) == before
    assert {path.name for path in tmp_path.iterdir()} <= {"places", home.name}
    assert not list(home.glob("runs/*"))


def status_of(command: Callable[[], int]) -> int | str | None:
    try:
        return command()
    except SystemExit as ended:
        return ended.code
