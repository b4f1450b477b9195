"""Contract: a recording becomes one page that plays, scrubs and shows the strips without a server, fetches nothing, and is
small enough to mail; `gaitshift view RECORDING` serves the same page."""

import math
import subprocess

import pytest
from conftest import until


@pytest.fixture(scope="module")
def recording(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("recording")
    command = [program, "transition", "--start-s", "6", "--after-s", "6", "--out", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "recording.csv"


# A biped on a slope climbed off the ground that was drawn, which was flat.
def test_the_ground_is_that_of_the_recording(program, tab, tmp_path):
    def surface(*words):
        command = [program, "evaluate", "--omega-v", "1", "--duration-s", "6", "--out", tmp_path, *words]
        subprocess.run(command, check=True, capture_output=True)
        html = tmp_path / "motion.html"
        subprocess.run([program, "export", "html", tmp_path / "omega_v_1.csv", "--out", html], check=True, capture_output=True)
        page = tab(html.as_uri())
        page.evaluate("() => { const s = document.getElementById('scrub'); s.value = 5; s.dispatchEvent(new Event('input')); }")
        page.wait_for_timeout(300)
        return page.evaluate("""() => { const { ground } = window.gaitshift.bipeds[0];
            const view = new View(ground, 3, 0, 100, 50); return [2.5, 3, 3.5].map((x) => view.onGround(x)[1]); }""")

    assert surface() == [100, 100, 100]
    left, middle, right = surface("--slope", "3deg")
    assert abs(middle - 100) < 0.1 and abs(left - right - 50 * math.tan(math.radians(3))) < 0.1


@pytest.mark.parametrize("served", [False, True])
def test_a_replay_plays_and_scrubs(program, recording, view, tab, tmp_path, served):
    html = tmp_path / "motion.html"
    subprocess.run([program, "export", "html", recording, "--out", html], check=True, capture_output=True)
    assert html.stat().st_size < 400_000
    page = tab(view(recording) if served else html.as_uri())

    def seek(time_s):
        page.evaluate(
            "t => { const s = document.getElementById('scrub'); s.value = t; s.dispatchEvent(new Event('input')); }", time_s
        )
        page.wait_for_timeout(100)

    seek(5.5)
    assert page.text_content("#gait") == "walking"
    assert page.text_content("#scrubOut") == "5.50 s"
    slow = float(page.text_content("#speed"))
    seek(12)
    assert page.text_content("#gait") == "running"
    assert float(page.text_content("#speed")) > slow
    seek(0)
    page.click("#play")
    until(page, "parseFloat(document.getElementById('scrubOut').textContent) > 1")
    page.keyboard.press("Escape")
    page.click("#play")
    stopped = page.text_content("#scrubOut")
    page.wait_for_timeout(300)
    assert page.text_content("#scrubOut") == stopped
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("ArrowRight")
    until(page, f"document.getElementById('scrubOut').textContent !== '{stopped}'")
    # The strips are drawn: some of their pixels are of the legs' colours.
    colours = page.evaluate("""() => { const c = document.getElementById('strips'); const p = c.getContext('2d')
        .getImageData(0, 0, c.width, c.height).data; let n = 0; for (let k = 0; k < p.length; k += 4)
        if (p[k] === 213 && p[k + 1] === 94) n++; return n; }""")
    assert colours > 100
    # In the scene the left leg is as pale as in the pictures (#0072b2, 0.55 of white), the right one in full colour: it was a
    # blue as dark as the right one's red, and they were the same in grey.
    page.emulate_media(color_scheme="light")
    page.wait_for_timeout(300)
    pale, full, right = page.evaluate("""() => { const c = document.getElementById('stage'); const p = c.getContext('2d')
        .getImageData(0, 0, c.width, c.height).data; const of = (r, g, b) => { let n = 0; for (let k = 0; k < p.length; k += 4)
        if (Math.abs(p[k] - r) < 2 && Math.abs(p[k + 1] - g) < 2 && Math.abs(p[k + 2] - b) < 2) n++; return n; };
        return [of(140, 192, 220), of(0, 114, 178), of(213, 94, 0)]; }""")
    assert pale > 100 and right > 100 and full < pale / 4, (pale, full, right)


def test_what_is_no_recording_is_refused(program, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("time_s,x\n0,1\n")
    for command in (["view", bad], ["export", "html", bad]):
        result = subprocess.run([program, *command], capture_output=True, text=True)
        assert result.returncode == 2
        assert "bad.csv" in result.stderr
