"""The generated pages say what the code says."""

import docs_tree as tree
import pytest

from dnanalyze.model.registry import built_in


def test_effect_pages_are_in_step_with_the_registry():
    made = tree.script("make_effects").pages(built_in())
    folder = tree.DOCS / "effects"
    written = {p.name: p.read_text() for p in folder.glob("*.md")}
    assert written == made, "run: python docs/make_effects.py"


def test_gallery_is_in_step_with_the_registry():
    made = tree.script("make_effects").gallery(built_in())
    assert (tree.DOCS / "gallery.md").read_text() == made, "run: python docs/make_effects.py"


def test_every_effect_has_its_figure():
    figures = {p.stem for p in (tree.DOCS / "effects").glob("*.png")}
    both = {f"{name}{tone}" for name in built_in() for tone in ("", "-dark")}
    assert figures == both, "run: python docs/make_effects.py"


def test_other_names_are_of_effects_of_the_catalogue():
    also = tree.script("make_effects").ALSO
    assert set(also) <= set(built_in())
    assert "banding" in also["row_noise"]


def test_a_figure_in_dark_keeps_its_images_and_turns_its_lines():
    from matplotlib.figure import Figure

    from dnanalyze.report.figures.palette import TONES

    module = tree.script("dark_figures")
    figure = Figure()
    ax = figure.subplots()
    (line,) = ax.plot([0, 1], color=TONES["model"][0])
    image = ax.imshow([[0.0, 1.0]], cmap="gray")
    module.darken(figure)
    assert line.get_color() == TONES["model"][1]
    assert image.get_cmap().name == "gray"


@pytest.mark.parametrize("page", ["statistics", "commands"])
def test_reference_is_in_step_with_the_code(page):
    made = getattr(tree.script("make_reference"), page)()
    assert (tree.DOCS / f"{page}.md").read_text() == made, "run: python docs/make_reference.py"


def test_strengths_of_the_figures_name_real_parameters():
    module = tree.script("make_effects")
    for name, strengths in module.STRENGTHS.items():
        assert set(strengths) <= set(built_in()[name].parameters()), name
    assert (module.WIDE | module.CODES | module.NEAR | set(module.OVER_TIME)) <= set(built_in())


def test_ticks_of_the_figures_are_plain_text(monkeypatch, tmp_path):
    module = tree.script("make_effects")
    monkeypatch.setattr(module, "SHAPE", (64, 64))
    monkeypatch.setattr(module, "FRAMES", 3)
    made = []
    monkeypatch.setattr(module, "save", lambda figure, path: made.append(figure))
    module.draw(built_in()["row_noise"], tmp_path / "row_noise.png")
    made[0].draw_without_rendering()
    ticks = [
        t.get_text() for ax in made[0].axes for t in (*ax.get_xticklabels(), *ax.get_yticklabels())
    ]
    assert "0.01" in ticks
    assert not [t for t in ticks if "$" in t]  # mathematics are switched off in the figures
