"""Contract: the study's page is readable in a wide and in a narrow window without scrolling sideways, holds its pictures,
fetches nothing, and on paper shows what is folded on the screen."""

import subprocess

import pytest

# The page with everything in it is the one of several experiments: a second name makes the shipped controller another one.
SUBJECTS = ("shipped", "robust")


@pytest.fixture(scope="module")
def report(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    subprocess.run([program, "report", "--quick", *SUBJECTS, "--out", folder], check=True, capture_output=True)
    return folder / "report.html"


@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_fits_the_window_and_fetches_nothing(report, tab, width):
    # `tab` fails the test if anything is fetched or an error is logged.
    page = tab(report.as_uri(), width=width)
    page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
    scroll, window = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert scroll <= window
    # Nothing sticks out of the page but what scrolls in a box of its own.
    outside = page.evaluate("""() => [...document.querySelectorAll('body *')]
        .filter(e => !e.closest('.scroll') && !e.closest('svg')
        && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map(e => e.outerHTML.slice(0, 120))""")
    assert outside == []
    # Within a picture, parts that are cut off at a panel's edge are `svg` elements too.
    figures = page.evaluate("""() => [...document.querySelectorAll('figure > div > svg')].map(e => {
        const box = e.getBoundingClientRect(), marks = e.querySelectorAll('path, line, polyline, circle');
        return [e.getAttribute('aria-label'), box.width, box.height, marks.length]; })""")
    assert len(figures) > 20
    for title, across, down, marks in figures:
        assert title and across > 200 and down > 50 and marks > 5, (title, across, down, marks)


def test_links_lead_to_files_beside_the_page(report, tab):
    page = tab(report.as_uri())
    links = page.evaluate("[...document.querySelectorAll('a')].map(a => a.getAttribute('href'))")
    files = {link for link in links if not link.startswith("#")}
    assert len(files) > 80
    assert [file for file in files if not (report.parent / file).is_file()] == []


def test_paper_shows_what_is_folded(report, tab):
    page = tab(report.as_uri())
    folded = "details:not([open])"
    assert page.locator(folded).count() >= 2

    def shown():
        return page.evaluate(f"""() => [...document.querySelectorAll('{folded} table, {folded} figure')]
            .filter(e => e.checkVisibility({{ contentVisibilityAuto: true }})
            && e.getBoundingClientRect().height > 0).length""")

    assert shown() == 0
    page.emulate_media(media="print")
    everything = page.locator(f"{folded} table, {folded} figure").count()
    assert everything > 10 and shown() == everything
