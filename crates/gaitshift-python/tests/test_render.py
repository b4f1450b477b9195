"""Contract: every render mode of Gymnasium that the environments name gives the pictures its wrappers expect, without a
display: frames of the present state, films of real time by RecordVideo, for one environment and for a vector."""

import json
import struct
import time
import urllib.request

import gymnasium
import numpy as np
import pytest
from websockets.sync.client import connect

import gaitshift

ID = "gaitshift/PassiveBiped-v0"


def test_frames_show_the_present_state():
    env = gymnasium.make(ID, render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert first.shape == (330, 640, 3)
    assert first.dtype == np.uint8
    np.testing.assert_array_equal(first, env.render())
    env.step(np.array([0.3, -0.3]))
    second = env.render()
    assert (first != second).any()
    # The right leg is vermilion, the left one pale blue, the paper white.
    for colour in [(213, 94, 0), (140, 192, 220), (255, 255, 255)]:
        assert (second == colour).all(axis=2).sum() > 100


def test_the_ground_is_that_of_the_episode():
    # It was drawn flat, whatever the biped stood on.
    def surface(**arguments):
        env = gaitshift.PassiveBipedEnv(render_mode="rgb_array", **arguments)
        env.reset(seed=1)
        soil = (env.render() == (236, 231, 223)).all(axis=2)
        return [int(np.flatnonzero(soil[:, column])[0]) for column in (235, 355)]

    left, right = surface()
    assert left == right
    # What lies lower on the left was drawn as level soil.
    left, right = surface(disturbance={"terrain": {"slope_rad": 0.1}})
    assert abs(left - right - 120 * np.tan(0.1)) < 2


def test_a_frame_needs_an_episode_and_a_mode():
    env = gaitshift.PassiveBipedEnv(render_mode="rgb_array")
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.render()
    plain = gaitshift.PassiveBipedEnv()
    plain.reset()
    assert plain.render() is None


def test_a_list_of_frames_holds_every_step():
    env = gymnasium.make(ID, render_mode="rgb_array_list")
    env.reset(seed=1)
    for _ in range(4):
        env.step(np.zeros(2))
    frames = env.render()
    assert len(frames) == 5
    assert all(frame.shape == (330, 640, 3) for frame in frames)
    assert env.render() == []


def test_the_frame_rate_is_that_of_real_time():
    assert gymnasium.make(ID, render_mode="rgb_array").metadata["render_fps"] == 200
    slow = gaitshift.PassiveBipedEnv(task={"control_period_s": 0.02}, render_mode="rgb_array")
    assert slow.metadata["render_fps"] == 50
    assert gaitshift.PassiveBipedVectorEnv(2, task={"control_period_s": 0.02}).metadata["render_fps"] == 50
    assert gaitshift.PassiveBipedEnv.metadata["render_fps"] == 200, "an instance does not change its class"


def test_a_vector_gives_one_frame_for_each_environment():
    envs = gymnasium.make_vec(ID, 3, render_mode="rgb_array")
    envs.reset(seed=1)
    frames = envs.render()
    assert len(frames) == 3
    single = gymnasium.make(ID, render_mode="rgb_array")
    single.reset(seed=2)
    np.testing.assert_array_equal(frames[1], single.render())
    envs.close()


def test_human_mode_opens_a_page_and_keeps_real_time(monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    slope = {"terrain": {"slope_rad": 0.05}}
    env = gaitshift.PassiveBipedEnv(render_mode="human", task={"control_period_s": 0.01}, disturbance=slope)
    env.reset(seed=1)
    assert opened == [env.url]
    with urllib.request.urlopen(env.url) as page:
        assert b'data-mode="watch"' in page.read()
    with connect(env.url.replace("http", "ws") + "socket") as socket:
        shown = json.loads(socket.recv(timeout=20))
        assert shown["type"] == "bipeds"
        # On the page the ground was flat.
        (x, z), (further, higher) = shown["bipeds"][0]["ground"][-2:]
        assert (higher - z) / (further - x) == pytest.approx(np.tan(0.05))
        begin = time.monotonic()
        for _ in range(20):
            env.step(np.zeros(2))
        assert time.monotonic() - begin > 0.15
        times = []
        while len(times) < 21:
            message = socket.recv(timeout=20)
            if isinstance(message, bytes):
                times.append(struct.unpack_from("<d", message, 12)[0])
        # The start, which the page had missed, first.
        assert times == pytest.approx([0.01 * k for k in range(21)])
    env.reset()
    assert len(opened) == 1
    env.close()
    end = time.monotonic() + 20
    with pytest.raises(OSError):
        while time.monotonic() < end:
            urllib.request.urlopen(env.url).close()


def films(folder):
    return sorted(folder.glob("*.mp4"))


def length_s(path):
    from moviepy import VideoFileClip

    with VideoFileClip(str(path)) as film:
        return film.duration


def test_record_video_films_the_single_environment_in_real_time(tmp_path):
    pytest.importorskip("moviepy")
    controller = gaitshift.Controller.shipped()
    env = gymnasium.make(ID, controller=controller, render_mode="rgb_array")
    env = gymnasium.wrappers.RecordVideo(env, str(tmp_path / "films"), video_length=50, disable_logger=True)
    observation, _ = env.reset(seed=1)
    for _ in range(60):
        observation, *_ = env.step(controller(observation))
    env.close()
    assert films(tmp_path / "films")
    assert length_s(films(tmp_path / "films")[0]) == pytest.approx(0.5, abs=0.1)


def test_record_video_films_the_vector(tmp_path):
    pytest.importorskip("moviepy")
    envs = gymnasium.make_vec(ID, 2, render_mode="rgb_array")
    envs = gymnasium.wrappers.vector.RecordVideo(envs, str(tmp_path / "films"), video_length=20, disable_logger=True)
    envs.reset(seed=1)
    for _ in range(30):
        envs.step(np.zeros((2, 2)))
    envs.close()
    assert films(tmp_path / "films")
