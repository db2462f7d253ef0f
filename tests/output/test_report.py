"""The page of a results folder: whole, alone, escaped, and with the numbers of the results."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import json
import re
import shutil
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed, toml
from web_page import Element, read_page

from fenics_nnm.backbone.point import CONVERGED, FAILED, VERIFIED, BranchPoint, Verdict
from fenics_nnm.cli import main
from fenics_nnm.errors import OutputError
from fenics_nnm.output.campbell_report import write_campbell
from fenics_nnm.output.html_report.campbell import campbell
from fenics_nnm.output.html_report.headlines import headlines, next_steps
from fenics_nnm.output.html_report.live_curve import live_curve
from fenics_nnm.output.html_report.words import aligned, length, plain, sentences, signed
from fenics_nnm.output.picture import Picture
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.results.tables import COLUMNS
from fenics_nnm.structure.campbell import AtSpeed

#: A title that would do harm as HTML, as a template, and in a caption.
HOSTILE = "</title><script>alert('1')</script> & $title <img src=x onerror=alert(1)> &lt; 50 %"

#: Two masses on springs of another code; the first one can touch.
MATRICES = {
    "title": "Two masses",
    "matrices": {"file": "matrices.npz"},
    "contact": {"gap": 1e-3},
    "reduction": {"modes": 1},
    **{key: ROD[key] for key in ("mode", "continuation")},
}


def ran(folder: Path, study: dict) -> Path:
    (folder / "study.toml").write_text(toml(study))
    assert main(["run", str(folder / "study.toml"), "--output", str(folder / "out")]) == 0
    return folder / "out"


def reported(results: Path, file: Path | None = None) -> Element:
    """The page of a results folder, if nothing is wrong with it that can be wrong with any."""
    assert main(["report", str(results), *(["--output", str(file)] if file else [])]) == 0
    page = read_page((file or results / "report.html").read_text("utf-8"))
    assert_alone(page)
    assert_guarded(page)
    assert_references(page)
    for section in page.all("section"):
        heading, *content = section.inside
        assert heading.tag == "h2" and heading.text
        assert all(each.text.strip() or each.all("img") for each in content) and content
    for table in page.all("table"):
        headings, *rows = table.rows()
        assert all(headings) and rows and all(len(row) == len(headings) for row in rows)
    return page


def assert_alone(page: Element) -> None:
    """Nothing is loaded from elsewhere; scripts are those of the live motion."""
    assert not page.all("iframe") + page.all("object")
    assert not any("src" in script.attributes for script in page.all("script"))
    for element in page.all("img") + page.all("link"):
        address = element.attributes.get("src", element.attributes.get("href", ""))
        assert address.startswith("data:")
    for style in page.all("style"):
        assert "url(" not in style.text and "@import" not in style.text
    for image in page.all("img"):
        assert image.attributes["alt"]
        kind, data = opened(image.attributes["src"])
        if kind == "image/svg+xml":
            assert ElementTree.fromstring(data).tag.endswith("svg")
        else:
            assert data[:4] in (b"\x89PNG", b"GIF8")


def assert_guarded(page: Element) -> None:
    """Browsers are told to load nothing from elsewhere, and to run no script but known ones."""
    (policy,) = (
        meta.attributes["content"]
        for meta in page.all("meta")
        if meta.attributes.get("http-equiv") == "Content-Security-Policy"
    )
    allowed = dict(each.strip().split(" ", 1) for each in policy.split(";"))
    assert allowed["default-src"] == "'none'"
    known = allowed.get("script-src", "").split()
    running = [e.text for e in page.all("script") if "type" not in e.attributes]
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()) for text in running]
    assert all(f"'sha256-{digest.decode()}'" in known for digest in digests)
    assert all(source.startswith("'sha256-") for source in known)
    assert allowed["img-src"] == "data:"
    assert all("http" not in e.attributes.get("src", "") for e in page.all("img"))
    assert not any(name.startswith("on") for e in page.all("svg") for name in e.attributes)


def assert_references(page: Element) -> None:
    """Every link inside the page leads somewhere, and every name is there once."""
    everything = [page]
    for element in everything:
        everything += element.inside
    names = Counter(e.attributes["id"] for e in everything if "id" in e.attributes)
    assert set(names.values()) == {1}
    wanted = [e.attributes["aria-labelledby"] for e in page.all("section")]
    wanted += [a.attributes["href"][1:] for a in page.all("a") if a.attributes["href"][0] == "#"]
    assert set(wanted) <= set(names) and len(wanted) == 2 * len(page.all("section"))
    assert page.all("html")[0].attributes["lang"] == "en"


def opened(address: str) -> tuple[str, bytes]:
    """Media type and contents of a data URI."""
    kind, data = re.fullmatch(r"data:([^;,]+);base64,(.*)", address, re.DOTALL).groups()
    return kind, base64.b64decode(data, validate=True)


def section(page: Element, name: str) -> Element:
    (found,) = [e for e in page.all("section") if e.attributes["id"] == name]
    return found


def labelled(page: Element, label: str) -> Element:
    (box,) = [e for e in page.all("div") if e.attributes.get("aria-label") == label]
    return box.all("table")[0]


def numbers(table: Element, heading: str) -> list[float]:
    headings, *rows = table.rows()
    place = headings.index(heading)
    return [float(row[place].replace(",", "")) for row in rows]


def records(results: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO((results / "backbone.csv").read_text())))


@pytest.fixture
def one_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """A single picture in place of all of them, which take their time."""

    def draw(results: Path, folder: Path, *, formats: tuple[str, ...]) -> tuple[Picture, ...]:
        folder.mkdir()
        (folder / "a.svg").write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="72pt" height="36pt"/>'
        )
        return (Picture("a.svg", 'The "curve"', "f < 1 & f > 0 <b>.", "frequency"),)

    monkeypatch.setattr("fenics_nnm.output.html_report.report.make_pictures", draw)


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    finer = {"harmonics": 20, "samples": 128}  # with 3 harmonics contact is not believed
    study = changed(PLATE, {"title": HOSTILE, "mode": finer})
    return ran(tmp_path_factory.mktemp("plate"), study)


@pytest.fixture(scope="module")
def elsewhere(plate: Path) -> Path:
    return plate.parent / "a page" / "plate.html"


@pytest.fixture(scope="module")
def page(plate: Path, elsewhere: Path) -> Element:
    return reported(plate, elsewhere)


def test_title_is_text_whatever_it_says(page: Element) -> None:
    assert page.all("h1")[0].text == HOSTILE
    assert page.all("title")[0].text == HOSTILE
    assert HOSTILE in section(page, "study").text


def test_points_are_those_of_the_table(plate: Path, page: Element) -> None:
    (table,) = section(page, "points").all("table")
    rows = records(plate)
    for heading, of, accuracy in (
        ("gamma ratio (1)", lambda row: float(row["gamma_ratio"]), 1e-5),
        ("frequency (Hz)", lambda row: float(row["frequency_Hz"]), 1e-7),
        ("hardening (%)", lambda row: 100 * (float(row["frequency_ratio"]) - 1), 0.05),
        ("energy (J)", lambda row: float(row["energy_J"]), 1e-4),
        ("contact (% of period)", lambda row: 100 * float(row["contact_fraction"]), 0.05),
    ):
        wanted = [of(row) for row in rows]
        np.testing.assert_allclose(numbers(table, heading), wanted, rtol=accuracy, atol=1e-6)
    headings, *cells = table.rows()
    statuses = [row[headings.index("status")] for row in cells]
    assert statuses == [row["status"] for row in rows]


def test_whole_table_is_in_the_page_and_beside_it(
    plate: Path, page: Element, elsewhere: Path
) -> None:
    download, beside = section(page, "points").all("a")
    kind, data = opened(download.attributes["href"])
    assert kind == "text/csv" and download.attributes["download"] == "backbone.csv"
    assert data == (plate / "backbone.csv").read_bytes()
    linked = elsewhere.parent / unquote(beside.attributes["href"])
    assert linked.samefile(plate / "backbone.csv")


def test_failed_points_make_no_headline(plate: Path) -> None:
    results = read_results(plate)
    first, *_, last = results.points
    failed = (replace(last, verdict=Verdict(FAILED, "comes back elsewhere")),)
    told = " ".join(sentences(replace(results, points=(first, *failed))))
    assert f"at {first.gamma_ratio:.4g}" in told and f"{first.motion.frequency:.6g} Hz" in told
    assert f"{last.motion.frequency:.6g} Hz" not in told and "1 failed" in told
    shown = replace(results, points=(first, *failed)).shown
    assert shown == (first,) and replace(results, points=failed).shown == failed
    assert "All points failed" in " ".join(sentences(replace(results, points=failed)))


def test_the_pointer_finds_the_numbers_of_each_point(plate: Path, page: Element) -> None:
    (drawing,) = section(page, "curve").all("svg")
    titles = [title.text.splitlines() for title in drawing.all("title")]
    rows = records(plate)
    assert len(titles) == len(rows)
    for lines, row in zip(titles, rows, strict=True):
        assert lines[0].startswith(row["status"])
        assert f"{float(row['frequency_Hz']):.7g} Hz" in lines[1]
        assert any("largest displacement" in line for line in lines)
        (stress,) = (line for line in lines if "von Mises" in line)
        assert f"{1e-6 * float(row['von_mises_Pa']):.4g} MPa" in stress
    places = [(float(e.attributes["cx"]), float(e.attributes["cy"])) for e in drawing.all("circle")]
    width, height = map(float, drawing.attributes["viewbox"].split()[2:])
    assert len(places) > 2
    assert all(0 < x < width and 0 < y < height for x, y in places)
    across = [x for x, _ in places]
    assert across == sorted(across)  # energies ascend


def test_engine_orders_are_lines_of_the_curve(plate: Path) -> None:
    results = read_results(plate)
    highest = max(point.motion.frequency for point in results.points)
    turning = f"{results.header.study}\n[rotation]\naxis = 'z'\nrpm = {30 * 1.02 * highest}\n"
    drawing = live_curve(replace(results, header=replace(results.header, study=turning)))
    assert "engine order 2" in drawing
    assert "engine order" not in live_curve(results)


def test_headlines_are_those_of_points_to_be_trusted(plate: Path) -> None:
    results = read_results(plate)
    told = dict(headlines(results))
    assert {p.status for p in results.trusted} <= {VERIFIED, CONVERGED}
    highest = max(p.motion.frequency for p in results.trusted)
    (name,) = (name for name in told if name.startswith("Highest frequency"))
    assert told[name] == f"{highest:.6g} Hz"
    largest = max(results.trusted, key=lambda p: p.motion.energy)
    moved = 1e3 * float(COLUMNS["displacement_m"].printed(largest))
    assert told[f"Largest motion ({largest.status})"].startswith(f"{moved:.4g} mm at ")
    *others, last = results.points
    jumped = replace(last, motion=replace(last.motion, frequency=1e6))
    failed = replace(jumped, verdict=Verdict(FAILED, "comes back elsewhere"))
    assert not any("e+06" in value for _, value in headlines(_with(results, *others, failed)))
    verified = replace(last, verdict=Verdict(VERIFIED))
    doubted = tuple(replace(p, verdict=Verdict(CONVERGED, "?")) for p in others)
    assert _with(results, *doubted, verified).chosen == (verified,)
    falling = replace(verified, at={**verified.at, "frequency_ratio": 0.9})
    assert dict(headlines(_with(results, falling)))["Largest softening (verified)"] == "-10.00 %"


def _with(results: Results, *points: BranchPoint) -> Results:
    return replace(results, points=points)


def test_advice_is_in_the_page(plate: Path, elsewhere: Path) -> None:
    results = read_results(plate)
    proposed = {**results.summary, "advice": ["2 points: set mode.harmonics = 5"]}
    shown = next_steps(replace(results, summary=proposed))
    assert "2 points: set mode.harmonics = 5." in shown.content[1]
    assert not next_steps(replace(results, summary={})).content


def test_tables_become_lists_on_a_telephone(page: Element) -> None:
    for table in page.all("table"):
        headings, *rows = table.all("tr")
        names = [each.text for each in headings.inside]
        for row in rows:
            assert [cell.attributes["data-heading"] for cell in row.inside] == names
    (style,) = page.all("style")
    narrow = style.text.partition("@media (max-width: 34rem)")[2]
    assert "attr(data-heading)" in narrow and "thead { display: none; }" in narrow
    assert not re.search(r"(?<!\()min-width:\s*[2-9]\d+rem", style.text)  # wider than a telephone


def test_words_have_the_numbers_of_the_summary(plate: Path, page: Element) -> None:
    summary, told = json.loads((plate / "summary.json").read_text()), section(page, "overview").text
    believed = [row for row in records(plate) if row["status"] != "failed"]
    highest = max(float(row["frequency_Hz"]) for row in believed)
    assert f"{summary['dofs']} degrees of freedom" in told
    assert f"{summary['contact_points']} contact points" in told and "a gap of 1 mm" in told
    assert f"{highest:.6g} Hz" in told
    linear = numbers(section(page, "linear").all("table")[0], "frequency (Hz)")
    np.testing.assert_allclose(linear, summary["linear_frequencies_Hz"], rtol=1e-6)
    verdicts = section(page, "verdicts").text
    assert all(f"{count} {status}" in verdicts for status, count in summary["statuses"].items())
    for version in summary["versions"].values():
        assert version in section(page, "versions").text


def test_stable_points_are_counted_as_the_table_has_them(plate: Path, page: Element) -> None:
    kinds = [row["stability"] for row in records(plate)]
    known, stable = sum(map(bool, kinds)), kinds.count("stable")
    which = "all of them are" if stable == known else f"{stable} are"
    assert stable > 1
    assert f"Stability is known of {known}: {which} stable." in section(page, "overview").text


def test_forces_are_those_of_the_branch(plate: Path, page: Element) -> None:
    import h5py

    with h5py.File(plate / "branch.h5") as file:
        (point,) = [p for p in file["points"].values() if p.attrs["gamma_ratio"] == 1.1]
        force, gap, areas = point["force"][:], file["model/gap"][:], file["contact/areas"][:]
    motions = labelled(page, "Contact of some motions")
    places = labelled(page, f"The {len(gap)} contact points")
    assert numbers(motions, "largest total force (N)") == pytest.approx(
        [force.sum(axis=1).max()], rel=1e-3
    )
    patches = labelled(page, "Contact patches")
    assert numbers(patches, "points") == [len(gap)]
    assert numbers(patches, "area (mm²)") == pytest.approx([1e6 * areas.sum()], rel=1e-3)
    assert numbers(patches, "largest gap (mm)") == [1.0]
    assert numbers(places, "gap (mm)") == pytest.approx(1e3 * gap, rel=1e-4)
    assert numbers(places, "area (mm²)") == pytest.approx(1e6 * areas, rel=1e-4)


@pytest.mark.usefixtures("one_picture")
def test_stopped_run_with_many_points(tmp_path: Path) -> None:
    energies = {"from": 0.8, "to": 1.1, "step": 0.004}
    results = ran(tmp_path, changed(ROD, {"continuation": {"energies": energies}}))
    rows = records(results)
    for name in ("summary.json", "backbone.csv"):
        (results / name).unlink()
    page = reported(results)
    (image,) = page.all("img")
    assert [image.attributes[name] for name in ("alt", "width", "height")] == [
        'The "curve"',
        "96",
        "48",
    ]
    (figure,) = (figure for figure in page.all("figure") if figure.all("img"))
    assert figure.all("figcaption")[0].text == 'The "curve". f < 1 & f > 0 <b>.'
    points = section(page, "points")
    shown = numbers(points.all("table")[0], "point")
    assert len(rows) > 70 and len(shown) <= 60
    assert shown[0] == 1 and shown[-1] == len(rows)
    (download,) = points.all("a")
    data = opened(download.attributes["href"])[1].decode()
    assert len(data.splitlines()) == len(rows) + 1
    assert "the run was stopped before its end" in section(page, "overview").text
    assert "from branch.h5. SI units" in page.all("footer")[0].text
    assert "Linear modes: the run was stopped" in section(page, "absent").text


def test_campbell_diagram_beside_the_results(tmp_path: Path) -> None:
    assert campbell(tmp_path / "rod") == ()
    beside = tmp_path / "rod-campbell"
    at = [AtSpeed(speed, np.array([hertz]), 1e-3) for speed, hertz in ((0.0, 1.0), (10.0, 1.0))]
    (met,) = write_campbell(beside, at, [1], title="Rod")
    assert met.speed == pytest.approx(2 * np.pi, rel=1e-12)
    (found,) = campbell(tmp_path / "rod")
    drawn = "".join(found.content)
    assert "data:image/svg+xml" in drawn and "<td" in drawn and "6.28319" in drawn
    (beside / "crossings.csv").write_text("engine_order\n1\n")
    with pytest.raises(OutputError, match=r"crossings\.csv: cannot be read"):
        campbell(tmp_path / "rod")


def test_preloaded_rod_says_what_is_closed_at_rest(tmp_path: Path) -> None:
    below = {"energies": {"from": 0.8, "to": 0.9, "step": 0.1}, "report_at": []}
    results = ran(tmp_path, changed(ROD, {"contact": {"gap": -1e-3}, "continuation": below}))
    told = " ".join(sentences(read_results(results)))
    # E A |gap| / L, the bar pushed back to its obstacle
    assert "At rest 1 of them are closed, pressed with 189,000 N in all" in told
    assert "across a gap of -1 mm" in told and "The gamma ratio is 1 at an energy" in told


@pytest.mark.usefixtures("one_picture")
def test_matrices_and_a_run_that_lacks_points(tmp_path: Path) -> None:
    K, M = np.array([[2e6, -1e6], [-1e6, 2e6]]), np.diag([1.0, 2.0])
    np.savez(tmp_path / "matrices.npz", K=K, M=M, B=np.array([[1.0, 0.0]]))
    results = ran(tmp_path, MATRICES)
    summary = json.loads((results / "summary.json").read_text())
    missing = {"gamma_ratio": 1.05, "reason": "Newton's method <stalls>"}
    summary |= {"complete": False, "reason": "1 energy has no point", "failures": [missing]}
    (results / "summary.json").write_text(json.dumps(summary))
    page = reported(results)
    told = section(page, "overview").text
    assert "matrices of another code with 2 degrees of freedom" in told
    assert "1 energy has no point" in told
    assert (
        "At gamma ratio 1.05 no motion on the branch was found: Newton's method <stalls>." in told
    )
    # lowest root of det(K - omega^2 M) = 2 x^2 - 6e6 x + 3e12
    lowest = np.sqrt(1e6 * (3 - np.sqrt(3)) / 2) / 2 / np.pi
    assert numbers(section(page, "linear").all("table")[0], "frequency (Hz)")[0] == pytest.approx(
        lowest, rel=1e-6
    )


def test_new_run_takes_the_page_of_the_old_one_away(plate: Path, tmp_path: Path) -> None:
    shutil.copytree(plate, tmp_path / "out")
    (tmp_path / "out" / "report.html").write_text("of older results")
    results = ran(tmp_path, ROD)
    assert not (results / "report.html").exists()


def test_no_results_is_one_line(tmp_path: Path, command: Callable[..., Ended]) -> None:
    command("report", tmp_path / "none").assert_one_line(1, "branch.h5", "results folder")


def test_a_page_replaces_no_study(tmp_path: Path, command: Callable[..., Ended]) -> None:
    study = tmp_path / "rod.toml"
    study.write_text("kept")
    ended = command("report", tmp_path, "--output", study)
    ended.assert_one_line(2, "rod.toml", "must end in .html or .htm")
    assert study.read_text() == "kept"


def test_numbers_are_written_as_people_write_them() -> None:
    assert [plain(x) for x in (0.0, 441337.2, 12.3456, 1e-9, 0.5)] == [
        "0",
        "441,337",
        "12.35",
        "1e-09",
        "0.5000",
    ]
    assert aligned([1297.18631, 15.5, 0.0], 6) == ["1297.19", "15.50", "0.00"]
    assert [signed(x) for x in (0.0, 1e-9, 17.4706, -0.00891)] == ["0", "0", "+17.47", "-0.0089"]
    assert [length(x) for x in (0.0, 3.56e-4, 1e-3, 2.0)] == ["0 m", "356 µm", "1 mm", "2 m"]


def test_animation_and_shapes_are_in_the_page(page: Element) -> None:
    kinds = Counter(opened(i.attributes["src"])[0] for i in section(page, "motion").all("img"))
    assert kinds["image/gif"] == 1 and kinds["image/png"] >= 2 and kinds["image/svg+xml"] >= 3
