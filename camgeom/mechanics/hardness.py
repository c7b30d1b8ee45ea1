"""What steel bears by the hardness of its surface."""

STEEL_MODULUS = 206000.0
"""MPa; hardened steel (T/WLJC 15-2018)"""
CONTACT_LIMIT = 2450.0
"""MPa at CONTACT_CYCLES; rolling contact of steel at 60 HRC (doi 10.13705/j.issn.1671-6833.2023.01.017)"""
CONTACT_CYCLES = 1e7
HARDNESS_CLASSES = ((60.0, CONTACT_LIMIT), (40.0, 1000.0), (0.0, 600.0))
"""HRC from which on, and MPa up to which a cam track bears; see `hardness_bound`"""


def hardness_bound(hardness: float) -> float:
    """Contact pressure, MPa, that steel of a surface hardness, HRC, bears at CONTACT_CYCLES, at most.

    The load classes of cam tracks (T/WLJC 15-2018): light, up to 600 MPa, 10 to 40 HRC; medium, 600 to 1000 MPa, 40 to
    60 HRC; heavy from 60 HRC on. That class ends at 1300 MPa, a load to design for; what steel of 60 HRC endures for
    CONTACT_CYCLES is CONTACT_LIMIT (doi 10.13705/j.issn.1671-6833.2023.01.017), and that is the bound taken here. To
    read classes of load as bounds of endurance is camgeom's own rule; between two classes nothing is interpolated.
    """
    return next(bound for least, bound in HARDNESS_CLASSES if hardness >= least)
