"""Ticks and labels of logarithmic axes.

Bokeh's ticks of fewer than two decades are linear, and its labels round their exponents: 0.2 and
0.4 were called 10^-1 and 10^0.
"""

from __future__ import annotations

from bokeh.models import CustomJSTicker, CustomJSTickFormatter

# 1, 2 and 5 times powers of ten; of less than a decade multiples of such a number, 5 at most.
TICKS = """
const sparse = false;
const [low, high] = [cb_data.start, cb_data.end].sort((a, b) => a - b);
if (!(low > 0 && high < Infinity)) return [];  // the range of the axis before
const decades = Math.log10(high / low);
const ticks = [];
if (decades < 1) {
  const least = (high - low) / 4;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].find((m) => m * power >= least) * power;
  for (let n = Math.ceil(low / step); n * step <= high; n++) ticks.push(n * step);
  return ticks;
}
const every = Math.ceil(decades / 6);
const of = decades > 3 ? [1] : !sparse || decades < 1.5 ? [1, 2, 5] : decades < 2.5 ? [1, 3] : [1];
for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++) {
  if (e % every === 0) {
    ticks.push(...of.map((m) => Number(`${m}e${e}`)));
  }
}
return ticks.filter((t) => low <= t && t <= high);
"""
LABEL = """
const e = Math.floor(Math.log10(tick) + 1e-9);
if (-3 <= e && e <= 3) return String(Number(tick.toPrecision(6)));
const power = "10" + String(e).replace("-", "⁻").replace(/[0-9]/g, (d) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);
const mantissa = Number((tick / 10 ** e).toPrecision(6));
return mantissa === 1 ? power : `${mantissa}·${power}`;
"""


def log_ticker(sparse: bool = False) -> CustomJSTicker:
    """Ticks of a logarithmic axis; ``sparse``: fewer, for a low figure."""
    code = TICKS.replace("sparse = false", "sparse = true") if sparse else TICKS
    return CustomJSTicker(major_code=code)


def log_formatter() -> CustomJSTickFormatter:
    """Labels that are the values of the ticks."""
    return CustomJSTickFormatter(code=LABEL)
