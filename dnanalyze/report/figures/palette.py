"""Colours of pages and figures, for light paper and for dark: one name, two tones."""

from __future__ import annotations

import re

# name: (on light paper, on dark). Okabe and Ito's hues: told apart by every kind of colour vision,
# and by lightness in grey.
TONES = {
    "ink": ("#1f2328", "#e6edf3"),
    "soft": ("#59636e", "#a3adb8"),
    "quiet": ("#8a929b", "#8b949e"),
    "line": ("#d9dee3", "#3a424c"),
    "grid": ("#eceff2", "#272d35"),
    "wash": ("#f6f8fa", "#1a2028"),
    "paper": ("#ffffff", "#12161c"),
    "model": ("#0072b2", "#4aa8e8"),
    "gaussian": ("#d55e00", "#f08c3a"),
    "accent": ("#009e73", "#2fbf93"),
    "calm": ("#8fbbd9", "#34638a"),
    "fair": ("#b7791f", "#d9a441"),
    "rose": ("#cc79a7", "#e09bc4"),
    "sky": ("#56b4e9", "#a5dcff"),
}
INK, SOFT, QUIET, HAIRLINE, GRID = (
    TONES[k][0] for k in ("ink", "soft", "quiet", "line", "grid")
)  # fmt: skip
PAPER, MODEL, GAUSSIAN, ACCENT, CALM = (
    TONES[k][0] for k in ("paper", "model", "gaussian", "accent", "calm")
)
ROSE, SKY = TONES["rose"][0], TONES["sky"][0]
# written onto a coloured cell, which is the same on light and on dark paper: never turned
ON_LIGHT, ON_DARK = "#101418", "#fefefe"

_NAMES = {light: name for name, (light, _) in TONES.items()}


def turning(text: str) -> str:
    """Colours of the palette as CSS variables, which the page sets; elsewhere they stay light."""
    return re.sub(
        r"#[0-9a-f]{6}",
        lambda m: f"var(--{_NAMES[m[0]]},{m[0]})" if m[0] in _NAMES else m[0],
        text,
    )
