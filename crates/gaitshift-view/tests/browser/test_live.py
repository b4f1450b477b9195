"""Contract: the live page loads without an error; its slider moves the gait from walking to running, read from the page's
own label; ready-made changes, pause, single steps, pushes, sliders of the body, comparison, keys, languages and saved
files do what they say; the saved history of the slider replays the saved motion to the last bit; nothing jumps."""

import csv
import io
import subprocess

import pytest
from conftest import until


def wait_for_gait(page, gait, which="gait"):
    until(page, f"document.getElementById('{which}').dataset.gait === '{gait}'")


def now(page):
    until(page, "window.gaitshift.now")
    return page.evaluate("window.gaitshift.now")


def save(page, what):
    with page.expect_download() as download:
        page.click(f"button.save[data-what={what}]")
    return download.value.path().read_bytes()


def move(page, omega_v):
    page.evaluate(
        "value => { const s = document.getElementById('omega'); s.value = value; s.dispatchEvent(new Event('input')); }",
        omega_v,
    )


def test_the_slider_moves_the_gait_from_walking_to_running_and_back(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    assert page.text_content("#gait") == "walking"
    walking = now(page)["bipeds"][0]
    for omega_v in (0.7, 1.5, 2.2, 3.0):
        move(page, omega_v)
    wait_for_gait(page, "running")
    page.wait_for_timeout(2000)
    running = now(page)["bipeds"][0]
    assert running["speed_m_per_s"] > 1.5 * walking["speed_m_per_s"]
    assert any(phase[0] == 3 for phase in running["phases"]), "a run has flight"
    assert float(page.text_content("#speed")) > 1.0
    move(page, 0.0)
    wait_for_gait(page, "walking")


def test_ready_made_changes_run_their_ramps(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.click("#toRun")
    until(page, "window.gaitshift.now.omega_v === 3")
    wait_for_gait(page, "running")
    page.click("#toWalk")
    until(page, "window.gaitshift.now.omega_v === 0")
    wait_for_gait(page, "walking")
    page.click("#round")
    wait_for_gait(page, "running")
    wait_for_gait(page, "walking")
    assert page.input_value("#omega") == "0"


def test_a_push_makes_it_stumble_and_it_recovers(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    box = page.locator("#stage").bounding_box()
    x, y = box["x"] + 0.46 * box["width"], box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 44, y, steps=5)
    page.mouse.up()
    wait_for_gait(page, "mixed")
    wait_for_gait(page, "walking")
    assert now(page)["epoch"] == 0, "it did not fall"


def test_a_push_too_hard_makes_it_fall_and_it_starts_again(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.fill("#force", "2000")
    page.fill("#pushTime", "0.3")
    page.click("#pushBack")
    wait_for_gait(page, "fallen")
    assert "starts again" in page.text_content("#state")
    wait_for_gait(page, "walking")


def test_pause_stops_time_and_a_step_is_one_control_period(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.click("#pause")
    until(page, "window.gaitshift.now.paused")
    before = page.evaluate("window.gaitshift.bipeds[0].track.last")
    page.wait_for_timeout(500)
    assert page.evaluate("window.gaitshift.bipeds[0].track.last") == before
    page.click("#step")
    until(page, f"window.gaitshift.bipeds[0].track.last > {before}")
    after = page.evaluate("window.gaitshift.bipeds[0].track.last")
    assert after - before == pytest.approx(0.01)
    page.keyboard.press("Escape")
    page.click("#reset")
    until(page, "window.gaitshift.now.epoch === 1")
    assert page.evaluate("window.gaitshift.bipeds[0].track.last") == 0


def test_slow_motion_slows_time(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.select_option("#pace", "0.1")
    until(page, "window.gaitshift.now.pace === 0.1")
    before = page.evaluate("[performance.now(), window.gaitshift.bipeds[0].track.last]")
    page.wait_for_timeout(3000)
    after = page.evaluate("[performance.now(), window.gaitshift.bipeds[0].track.last]")
    assert (after[1] - before[1]) / ((after[0] - before[0]) / 1000) == pytest.approx(0.1, rel=0.15)


def test_sliders_of_the_body_act_at_once(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.click("#bodyPanel summary")
    slider = page.locator("#body_gravity_m_per_s2")
    slider.evaluate("s => { s.value = -1; s.dispatchEvent(new Event('input')); }")
    # A quarter of gravity: the same legs carry a quarter of the weight.
    until(page, "window.gaitshift.bipeds[0].body.gravity_m_per_s2 < 2.5")
    assert page.evaluate("window.gaitshift.bipeds[0].weight") == pytest.approx(40 * 9.81 / 4)
    page.click("#bodyReset")
    until(page, "window.gaitshift.bipeds[0].body.gravity_m_per_s2 === 9.81")
    page.locator("#body_friction").evaluate("s => { s.value = -1; s.dispatchEvent(new Event('input')); }")
    until(page, "window.gaitshift.bipeds[0].body.friction === 0.25")


def test_two_bipeds_side_by_side_share_the_slider(view, tab, tmp_path):
    heavy = tmp_path / "heavy.toml"
    heavy.write_text("hip_mass_kg = 22.0\n")
    page = tab(view("--body", heavy))
    wait_for_gait(page, "walking")
    page.check("#compare")
    until(page, "window.gaitshift.now.bipeds.length === 2")
    wait_for_gait(page, "walking")
    wait_for_gait(page, "walking", "gait2")
    page.click("#toRun")
    wait_for_gait(page, "running", "gait2")
    page.uncheck("#compare")
    until(page, "window.gaitshift.now.bipeds.length === 1")


def test_keys_move_the_slider_and_stop_time(view, tab):
    page = tab(view())
    wait_for_gait(page, "walking")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    until(page, "Math.abs(window.gaitshift.now.omega_v - 0.5) < 1e-9")
    page.keyboard.press("ArrowLeft")
    until(page, "Math.abs(window.gaitshift.now.omega_v - 0.4) < 1e-9")
    page.keyboard.press(" ")
    until(page, "window.gaitshift.now.paused")
    page.keyboard.press(" ")
    until(page, "!window.gaitshift.now.paused")


def test_a_report_from_before_a_key_does_not_take_it_back(view, tab):
    # A report that the program had sent before the key reached it set the slider back: the next key started from
    # there, and of five keys in a row one or more were lost.
    page = tab(view())
    wait_for_gait(page, "walking")
    page.evaluate("""() => {
        const before = { ...window.gaitshift.now, bipeds: [] };
        const press = (key) => document.body.dispatchEvent(
            new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
        for (let times = 0; times < 5; times += 1) { press("ArrowRight"); hear(before); }
        press(" ");
        hear(before);
    }""")
    until(page, "Math.abs(window.gaitshift.now.omega_v - 0.5) < 1e-9 && window.gaitshift.now.paused")
    assert page.evaluate("+document.getElementById('omega').value") == 0.5
    assert page.evaluate("control.paused")


def test_the_saved_history_replays_the_saved_motion_to_the_last_bit(view, tab, program, tmp_path):
    page = tab(view())
    wait_for_gait(page, "walking")
    for omega_v in (0.31, 0.77, 1.9, 2.6):
        move(page, omega_v)
        page.wait_for_timeout(120)
    page.wait_for_timeout(1500)
    page.click("#toWalk")
    page.wait_for_timeout(1000)
    page.click("#pause")
    until(page, "window.gaitshift.now.paused")
    page.fill("#saveTime", "60")
    recording, profile = save(page, "recording"), save(page, "profile")
    (tmp_path / "profile.csv").write_bytes(profile)
    command = [program, "transition", "--command-profile", tmp_path / "profile.csv", "--out", tmp_path, "--json"]
    subprocess.run(command, check=True, capture_output=True)

    def rows(text):
        lines = text.splitlines()
        return list(csv.reader(io.StringIO("\n".join(lines[1:]))))

    saved, replayed = rows(recording.decode()), rows((tmp_path / "recording.csv").read_text())
    assert len(saved) > 500
    # The program's recording has details behind the columns that every recording has.
    replayed = [row[: len(saved[0])] for row in replayed]
    # The numbers are written in the shortest form that reads back to the same bits.
    assert saved == replayed[: len(saved)]


def test_pictures_films_and_pages_are_saved(view, tab, tmp_path):
    page = tab(view())
    wait_for_gait(page, "walking")
    page.wait_for_timeout(2000)
    page.fill("#saveTime", "5")
    assert save(page, "picture").startswith(b"\x89PNG")
    assert save(page, "gif").startswith(b"GIF89a")
    if page.is_visible("button.film"):
        assert save(page, "mp4")[4:8] == b"ftyp"
    html = save(page, "page")
    path = tmp_path / "motion.html"
    path.write_bytes(html)
    replay = tab(path.as_uri())
    assert replay.text_content("#gait") != "–"


def test_several_tabs_have_stages_of_their_own(view, tab):
    url = view()
    first, second = tab(url), tab(url)
    wait_for_gait(first, "walking")
    wait_for_gait(second, "walking")
    first.click("#toRun")
    wait_for_gait(first, "running")
    assert now(second)["omega_v"] == 0
    assert second.get_attribute("#gait", "data-gait") == "walking"


@pytest.mark.parametrize("width", [1280, 380])
def test_the_page_fits_and_nothing_jumps(view, tab, width):
    page = tab(view(), width=width, height=800, dark=width < 500)
    boxes = """() => [...document.querySelectorAll('canvas, button, input, .figure, .gait')]
        .filter(e => e.offsetParent).map(e => { const b = e.getBoundingClientRect();
            return [e.id || e.className, Math.round(b.x), Math.round(b.y + scrollY)]; })"""
    wait_for_gait(page, "walking")
    before = page.evaluate(boxes)
    page.click("#toRun")
    wait_for_gait(page, "running")
    assert page.evaluate(boxes) == before
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_japanese_and_english(view, tab):
    page = tab(view(), language="ja-JP")
    wait_for_gait(page, "walking")
    assert page.text_content("#gait") == "歩行"
    missing = "Object.keys(WORDS.en).filter(k => !(k in WORDS.ja)).concat(Object.keys(WORDS.ja).filter(k => !(k in WORDS.en)))"
    assert page.evaluate(missing) == []
    page.click("#language")
    until(page, "document.getElementById('gait').textContent === 'walking'")
    assert page.evaluate("document.documentElement.lang") == "en"
