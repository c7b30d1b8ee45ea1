"""Sheets, plots and dimensioned views as data, written as SVG or PDF; no cam words."""
