"""Cutter data: where a tool stands, and how its axis points, to make the flanks of a cam.

`spec` is the [cutter] table, `tool` the body of the tool, `path` its positions beside a roller's track, `contour` those
round a planar profile, `rows` those of a ball, `sampling` the equal-error blocks, `leads` how the tool comes and goes,
`machine` the axes of a rotary-table mill, `rest` what the tool leaves, and `plan` all of it for one cam.
"""
