"""Cutter data: where a tool stands, and how its axis points, to make the flanks of a cam.

`spec` is the [cutter] table, `tool` the body of the tool, `path` its positions beside a roller's track, `rows` those of
a ball, `contour` those round a planar profile, `sampling` the equal-error blocks, `machine` the axes of a rotary-table
mill, `job` what a cam and its table make of these, `plan` all passes for one cam, `rest` what the tool leaves at a
place, and `outcome` what it leaves of the whole cam.
"""
