"""What assembly and manufacturing errors cost in follower motion, backlash, preload and pressure.

Errors move cam, follower and rollers a little from where the drawing has them; every contact line of a roller or face
then presses a little earlier or later (`contacts`, `causes`), and the follower stands where the walls that bear let it
(`seat`). `sensitivity` tells what each error does alone, `samples` what all of them do together in many machines (at
one place: `places`), `machine` what all followers of a machine keep, and which tolerances a wanted yield allows. Units
mm, rad, N; a cause's own unit stands beside it.
"""
