"""What a localizer answers: one surface that passes through the contacts, with what is known of its quality."""

from tactfix.geometry.surfaces import SidedSurface
from tactfix.values import frozen_value


@frozen_value
class SurfaceCandidate:
    """One surface that explains the contacts; radius is the offset radius that went in or was found.

    chi2: sum of squared residuals over sigma; without sigmas over the rounding of the coordinates. rms: of the
    residuals, in the contacts' unit. condition: how much the worst known parameter moves, in units of the contacts'
    extent (angles in rad), when the contacts, and the distances where there are any, move by one unit of that extent;
    infinite at a double root.
    poorly_determined: the surface is a double root, or so close to one that noise of size sigma can merge it with its
    neighbour or make both complex.
    """

    surface: SidedSurface
    chi2: float
    rms: float
    condition: float
    poorly_determined: bool
