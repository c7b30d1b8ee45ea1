"""Cutter data: where a tool stands, and how its axis points, to make the flanks of a cam.

`spec` is the [cutter] table, `tool` the body of the tool, `path`, `path_mill` and `path_touch` its positions beside a
roller's track, `contour` those round a planar profile, `rows` those of a ball, `sampling` the equal-error blocks,
`leads` how the tool comes and goes, `machine` the axes of a rotary-table mill, `plan` all passes for one cam, `rest`
what the tool leaves at a place, and `outcome` what it leaves of the whole cam.
"""
