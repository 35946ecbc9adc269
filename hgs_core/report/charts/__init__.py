"""Charts as SVG text: lines, bars, columns and scatters with axes, direct labels and tooltips; no plotting library.

Every chart is `WIDTH` units wide, so that its letters stay readable where the page is as narrow as a phone. Colours are
CSS variables of the page (`--s0` to `--s7`, `--ink`, `--faint`, `--rule`).
"""

from hgs_core.report.charts.bars import Bar, Part, bar_chart
from hgs_core.report.charts.columns import column_chart
from hgs_core.report.charts.lines import Series, TopAxis, line_chart
from hgs_core.report.charts.scatter import Point, scatter_chart

__all__ = [
    "Bar",
    "Part",
    "Point",
    "Series",
    "TopAxis",
    "bar_chart",
    "column_chart",
    "line_chart",
    "scatter_chart",
]
