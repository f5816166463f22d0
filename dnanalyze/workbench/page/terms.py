"""Terms of the page with the glossary's sentences, and effects by plain names."""

from __future__ import annotations

import html

from dnanalyze.report.leads import plain_name as in_words

SENTENCES = {
    "model error": (
        "Root mean square of z within each family, averaged over the families, on the held-out "
        "data. 1.0: the model is as close to the captures as a second sensor of the same design "
        "would be."
    ),
    "sigma": (
        "Standard deviation of the difference between two sensors of the same design: √2 times "
        "the standard error of one, corrected by the scatter of sensors simulated with the model."
    ),
    "robust sigma": (
        "Half of the distance between the 16 % and 84 % quantiles. Equal to the standard "
        "deviation for a normal distribution, and not affected by hot pixels."
    ),
    "family": (
        "Group of statistics of one kind; each family has the same weight in the model error."
    ),
    "operating point": "Temperature, exposure time, gain and channel of a group of frames.",
    "temporal noise": (
        "Standard deviation of a pixel over the frames of an operating point, root mean square "
        "over the pixels."
    ),
    "temporal dark noise": (
        "Standard deviation of a pixel over the frames of an operating point, root mean square "
        "over the pixels."
    ),
    "temporal variance": "Square of the temporal dark noise.",
    "DSNU": (
        "Standard deviation over the pixels of the mean dark frame, corrected for what is left of "
        "the temporal noise."
    ),
    "shading": (
        "Slow variation of the fixed pattern over the field, as coefficients of cosines (order "
        "across, order down)."
    ),
    "kurtosis": (
        "Third and fourth standardized central moments; both are 0 for a normal distribution "
        "(kurtosis minus 3)."
    ),
    "skewness": (
        "Third and fourth standardized central moments; both are 0 for a normal distribution "
        "(kurtosis minus 3)."
    ),
    "quantile": "Value below which the stated share of the pixels lies.",
    "hot pixel": (
        "Pixel whose mean is more than 5 robust standard deviations above the median. Other "
        "thresholds are stated."
    ),
    "tail index": "Exponent of a power-law tail (Hill estimator).",
    "taps": (
        "Groups of columns read through different amplifiers, with different offsets."
    ),
    "spectral peak": (
        "A single frequency with more power than its surroundings, from a periodic pattern."
    ),
    "power": (
        "Squared magnitude of the discrete Fourier transform divided by the number of pixels. "
        "White noise of variance s² has the power s² at every frequency."
    ),
    "confidence": (
        "Probability that the effect is the right one among the candidates and \"nothing is "
        "missing\""
    ),
    "detection limit": (
        "Smallest strength of an effect that these captures would show as significant."
    ),
    "AUC": (
        "Probability that a measured patch gets a higher score than a simulated one; 0.5 where a "
        "classifier cannot distinguish them."
    ),
}  # fmt: skip
NAMES = {"convolved_lognormal": "Wang 2025 model (convolved log-normal)", "pedestal": "Black level"}


def explained(*terms: str) -> str:
    """A "?" that opens the glossary's sentence on the first of some terms that has one.

    A longer text stands for the longest term in it; nothing where none has a sentence.
    """
    for text in terms:
        low = text.lower()
        held = [term for term in SENTENCES if term.lower() in low]
        if held:
            term = max(held, key=len)
            said = html.escape(SENTENCES[term], quote=True)
            return (
                f'<details class=term><summary title="{said}" aria-label="{term}">?</summary>'
                f"<div><b>{html.escape(term)}</b>: {said}</div></details>"
            )
    return ""


def with_term(text: str) -> str:
    """A text with the "?" of its term, which stays on the line of the last word.

    Examples
    --------
    >>> from dnanalyze.workbench.page.terms import with_term
    >>> with_term("mean < 3"), with_term("two taps")[:41]
    ('mean &lt; 3', "two <span style='white-space:nowrap'>taps")
    """
    mark = explained(text)
    if not mark:
        return html.escape(text)
    before, _, last = text.rpartition(" ")
    kept = f"<span style='white-space:nowrap'>{html.escape(last)}{mark}</span>"
    return f"{html.escape(before)} {kept}" if before else kept


def plain_name(effect: str) -> str:
    """An effect's name in words.

    Examples
    --------
    >>> from dnanalyze.workbench.page.terms import plain_name
    >>> plain_name("column_fpn"), plain_name("dark_shot_noise"), plain_name("adc_gain")
    ('Column FPN', 'Dark shot noise', 'ADC gain')
    """
    if effect in NAMES:
        return NAMES[effect]
    text = in_words(effect)
    return text[:1].upper() + text[1:]
