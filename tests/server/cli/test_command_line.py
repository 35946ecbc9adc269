from __future__ import annotations

from pathlib import Path

import pytest

from server.cli.command_line import CommandLine


@pytest.fixture
def parser() -> CommandLine:
    made = CommandLine(prog="hgs")
    commands = made.add_subparsers(metavar="COMMAND", required=True)
    train = commands.add_parser("train")
    train.add_argument("capture", type=Path)
    train.add_argument("--title")
    train.add_argument("--rate", type=float)
    train.add_argument("--count", type=int)
    train.add_argument("--preset", choices=["preview", "best"])
    commands.add_parser("check")
    return made


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("trian x", "hgs: argument COMMAND: unknown choice 'trian'; did you mean train?; see hgs --help\n"),
        ("qqq", "choose from train, check; see hgs --help\n"),
        ("train x --titel y", "unknown argument '--titel'; did you mean --title?; see hgs train --help\n"),
        ("train x --preset bset", "did you mean best?"),
        ("train x y", "unknown argument 'y'"),
        ("train", "the following arguments are required: capture; see hgs train --help\n"),
        ("train x --rate nan", "argument --rate: 'nan' is not a finite number"),
        ("train x --rate=-inf", "is not a finite number"),
        ("train x --count 1.5", "argument --count: '1.5' is not a whole number"),
        ("train x --count 99999999999999999", "a number of 17 digits is too large"),
        ("train x --title a\udcffb", "is not UTF-8 text"),
    ],
)
def test_what_is_wrong_is_one_line_with_the_word_that_was_meant(
    parser: CommandLine, line: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(line.split())
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_an_empty_path_is_not_the_folder_one_stands_in(parser: CommandLine, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parser.parse_args(["train", ""])
    assert "the path is empty" in capsys.readouterr().err


def test_what_is_right_is_read(parser: CommandLine) -> None:
    read = parser.parse_args(["train", "a\udcff", "--rate", "-1.5", "--count=-3", "--title", "Zo\udcc3\udcab"])
    assert (read.capture, read.rate, read.count, read.title) == (Path("a\udcff"), -1.5, -3, "Zoë")
