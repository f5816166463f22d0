"""Colours, style sheet and plain figures of the page, light and dark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bokeh.models import BasicTickFormatter, HoverTool
from bokeh.plotting import figure


@dataclass(frozen=True)
class Palette:
    """Colours of a theme; curves after Okabe and Ito, which the colour-blind can tell apart."""

    name: str
    background: str
    card: str
    ink: str
    quiet: str
    line: str
    present: str
    wang: str
    candidate: str
    good: str
    heat: tuple[str, ...]


LIGHT = Palette(
    "light", "#f3f4f6", "#ffffff", "#16191d", "#5b6470", "#d5d9df", "#0072b2", "#b86e00",
    "#b5348f", "#00785a", ("#eef3f8", "#c6dcee", "#8dbfe0", "#f2c46d", "#e07b39", "#a8321a"),
)  # fmt: skip
DARK = Palette(
    "dark", "#14171a", "#1d2125", "#eceff2", "#9aa4af", "#363d44", "#56b4e9", "#e69f00",
    "#e58ac9", "#3ecf9b", ("#23303b", "#2b5470", "#3f86b3", "#c79632", "#d9702e", "#f0543a"),
)  # fmt: skip


def palette(theme: str) -> Palette:
    """By name; light for any other."""
    return DARK if theme == "dark" else LIGHT


def sheet(p: Palette) -> str:
    """Style sheet of the page."""
    return f"""
:root {{ --bg:{p.background}; --card:{p.card}; --ink:{p.ink}; --quiet:{p.quiet};
  --line:{p.line}; --present:{p.present}; --candidate:{p.candidate}; color-scheme:{p.name}; }}
html {{ overflow-x:hidden; }}
html, body {{ background:var(--bg); color:var(--ink); margin:0; min-height:100%;
  font:13px/1.35 system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif; }}
"""


def layout() -> str:
    """Style sheet of the page's panes: frames across, below them failures, model and diagnosis.

    These fill the screen below the verdict, however many lines it has; the history follows.
    """
    return """
:host { display:grid !important; gap:6px; padding:4px 6px 6px;
  height:calc(100vh + 216px) !important;
  box-sizing:border-box; grid-template-columns:minmax(0, 1fr) 372px 352px;
  grid-template-rows:28px max-content minmax(250px, 34fr) minmax(412px, 53fr) 210px;
  grid-template-areas:'bar bar bar' 'strip strip strip' 'sensor sensor sensor'
    'fails model missing' 'history history history'; }
@media (min-width:2200px) { :host { grid-template-columns:minmax(0, 1fr) 560px 520px; } }
@media (max-width:1279px) { :host { grid-template-columns:minmax(0, 1fr) 372px;
  height:auto !important;
  grid-template-rows:28px max-content 600px 560px 420px 260px;
  grid-template-areas:'bar bar' 'strip strip' 'sensor sensor' 'fails model'
    'missing missing' 'history history'; } }
"""


def inner(p: Palette) -> str:
    """Style sheet of widgets, which live in shadow roots of their own."""
    return f"""
:host {{ --ink:{p.ink}; --design-primary-color:{p.present}; color:{p.ink}; font-size:12px;
  font-family:system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif; }}
.bk-input, .noUi-target, .bk-btn {{ background-color:{p.card} !important; color:{p.ink} !important;
  border-color:{p.line} !important; font-size:12px !important; }}
.bk-input {{ padding:1px 5px !important; min-height:22px !important; height:24px !important; }}
select.bk-input {{ padding-right:20px !important; text-overflow:ellipsis;
  background-image:{_arrow(p.quiet)} !important; }}
.bk-spin-btn {{ --color:{p.quiet}; --disabled-color:{p.line}; }}
.bk-btn {{ padding:2px 9px !important; }}
.bk-btn-primary {{ background-color:{p.present} !important; color:{p.card} !important; }}
.bk-btn:disabled {{ opacity:.45; }}
.bk-active.bk-btn {{ background-color:{p.present} !important; color:{p.card} !important; }}
label, .bk-slider-title {{ color:{p.quiet}; font-size:11px; }}
.noUi-target {{ height:6px !important; width:auto !important; margin:9px 8px !important;
  box-shadow:none !important; }}
.noUi-connect {{ background:{p.present} !important; }}
.noUi-handle {{ width:14px !important; height:14px !important; top:-5px !important;
  right:-7px !important; border-radius:50% !important; background:{p.present} !important;
  box-shadow:none !important; border:none !important; }}
.noUi-handle::before, .noUi-handle::after {{ display:none; }}
h2 {{ font-size:13px; margin:0; font-weight:650; color:{p.ink}; }}
.quiet {{ color:{p.quiet}; }}
.error {{ font-size:26px; font-weight:700; color:{p.present}; }}
a {{ color:{p.present}; }}
.wrong {{ color:{p.heat[5]}; }}
.loading {{ color:{p.quiet}; padding:8px 0; }}
.notes {{ display:inline-block; position:relative; }}
.notes summary {{ cursor:pointer; text-decoration:underline; list-style:none; }}
.notes ul {{ position:absolute; z-index:60; left:-100px; top:16px; width:420px; margin:0;
  padding:8px 8px 8px 24px; background:{p.card}; color:{p.ink}; border:1px solid {p.quiet};
  border-radius:5px; white-space:normal; }}
.term {{ display:inline-block; position:relative; margin-left:4px; font-weight:400; }}
.term summary {{ list-style:none; cursor:help; width:13px; height:13px; border-radius:50%;
  border:1px solid {p.line}; color:{p.quiet}; font-size:9px; line-height:13px;
  text-align:center; }}
.term summary::-webkit-details-marker {{ display:none; }}
.term > div {{ position:absolute; z-index:60; left:-60px; top:17px; width:260px; padding:6px 8px;
  background:{p.card}; color:{p.ink}; border:1px solid {p.quiet}; border-radius:5px;
  font-size:12px; font-weight:400; text-align:left; white-space:normal; }}
"""


def _arrow(colour: str) -> str:
    """Arrow of a choice, as an image of a style sheet; Bokeh's is black in both themes."""
    return (
        "url(\"data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 25 20'"
        f"%3E%3Cpath fill='%23{colour[1:]}' d='M0 0h25L12.5 20z'/%3E%3C/svg%3E\")"
    )


def card(p: Palette) -> dict[str, str]:
    """Styles of a pane."""
    return {
        "background": p.card,
        "border": f"1px solid {p.line}",
        "border-radius": "6px",
        "padding": "6px 8px",
        "color": p.ink,
        "min-width": "0",  # Panel's is the sum of the widths in a row
    }


def plain_figure(p: Palette, **options: Any) -> Any:
    """A Bokeh figure in the theme's colours."""
    settings: dict[str, Any] = {
        "toolbar_location": None,
        "background_fill_color": p.card,
        "border_fill_color": p.card,
        "outline_line_color": p.line,
        "min_border": 2,
        "output_backend": "canvas",
    }
    made = figure(**(settings | options))
    for axis in (*made.xaxis, *made.yaxis):
        axis.axis_line_color = p.quiet
        axis.major_tick_line_color = p.quiet
        axis.minor_tick_line_color = None
        axis.major_label_text_color = p.ink
        axis.axis_label_text_color = p.ink
        axis.major_label_text_font_size = "10px"
        axis.axis_label_text_font_size = "10px"
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_standoff = 3
        if isinstance(axis.formatter, BasicTickFormatter):
            axis.formatter.use_scientific = False
    made.grid.grid_line_color = p.line
    made.grid.grid_line_alpha = 0.6
    return made


def hover(p: Palette, renderers: Any, *rows: tuple[str, str], **options: Any) -> HoverTool:
    """A hover tool over some glyphs."""
    return HoverTool(tooltips=list(rows), renderers=renderers, **options)
