"""Contract: the package brings the program `gaitshift` along: as a command and as a module it says and writes what the
program built alone does, with the same exit codes, and Ctrl-C stops it."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

COMMAND = [str(Path(sys.executable).parent / "gaitshift")]
MODULE = [sys.executable, "-m", "gaitshift"]


@pytest.mark.parametrize("start", [COMMAND, MODULE], ids=["command", "module"])
def test_it_says_what_the_program_says(program, start):
    for arguments in (["--version"], ["evaluate", "--help"], ["evaluate", "--omega-v", "0,3", "--json"]):
        said = subprocess.run([*start, *arguments], check=True, capture_output=True).stdout
        assert said == program(*arguments), arguments


def test_a_run_names_the_command_that_made_it(tiny, tmp_path):
    out = tmp_path / "run"
    subprocess.run([*COMMAND, "train", tiny, "--out", out], check=True, capture_output=True)
    # Of the provenance in the file's header.
    assert b"gaitshift train" in (out / "controller-last.safetensors").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["evaluate", "no-such-file"], 2, "no-such-file"),
        (["evaluate", "--no-such-flag"], 2, "--no-such-flag"),
        ([], 2, "Usage"),
    ],
)
def test_exit_codes_are_the_programs(arguments, code, words):
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True)
    assert done.returncode == code and words in done.stderr


def test_ctrl_c_stops_training_with_a_checkpoint_and_anything_else_at_once(tmp_path):
    out = tmp_path / "run"
    training = subprocess.Popen([*MODULE, "train", "fast", "--out", out], stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while not (out / "config.toml").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.5)
    training.send_signal(signal.SIGINT)
    assert training.wait(timeout=60) == 130
    assert (out / "checkpoint").is_dir()
    # A command of a minute that does not ask for Ctrl-C itself.
    # A shell's background job ignores Ctrl-C, and so would what it starts; this test may be part of one.
    stress = subprocess.Popen(
        [*MODULE, "stress"],
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    time.sleep(2)
    stress.send_signal(signal.SIGINT)
    assert stress.wait(timeout=10) in (130, -signal.SIGINT)
