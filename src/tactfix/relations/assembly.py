"""Solutions for a fixture by relations: rigid bodies, or features located alone and then fitted together.

Distances and angles leave a fixture a few shapes (`realization`): mirror images, and one for each branch of a relation
(`equations`). The method depends on the relations:

1. If they fix the shape exactly and leave few shapes, each shape is a rigid fixture. All of its poses are found as for
   a fixture by geometry (`rigid_bodies`).
2. Otherwise the features are located alone, as in the paper (`combinations`). If some cannot be located, or only
   weakly, and the shape is free, least squares start from a hundred random placements, side by side (`placements`). If
   contacts and relations leave a motion free, the result is samples of a continuum.
3. If the shape is fixed, but features are not located, or weakly, or in too many combinations, the rigid shapes are
   searched. For relations with a sigma, the sigma of the contacts is first widened by that of the shape; one least
   squares over pose and shape follows from each pose (`branch_fits`).
4. Otherwise the same least squares start from each combination of candidates, on each branch that the contacts do not
   exclude (`branches`).
5. If the relations are exact, the shapes that the fits are near are searched as in step 1. If they are not exact, or no
   shape is near, the fits are the solutions.

Solutions that the contacts do not distinguish are merged, and the covariance covers all of them (`unresolved`).
"""

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.poses.solution import Solutions
from tactfix.relations.realization import FEW_BODIES, searchable_bodies
from tactfix.relations.rigid_bodies import body_solutions


def assembled_solutions(fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True) -> Solutions:
    """Every pose of a fixture by relations that explains contacts and relations; sigmas (n,) of the residuals.

    If there is none, the pose of least chi2 alone, above the limit. If contacts and relations leave a motion free,
    samples, marked as a continuum. with_misses False: neither of these.
    """
    shapes = searchable_bodies(fixture)
    is_exact = bool(shapes) and all(relation.sigma == 0 for relation in fixture.relations)
    if is_exact and len(shapes) <= FEW_BODIES:  # step 1
        return body_solutions(fixture, shapes, contacts, sigmas, with_misses)
    # Imported only where it is needed: on the command line importing takes longer than locating.
    from tactfix.relations.combined import combined_solutions

    return combined_solutions(fixture, contacts, sigmas, shapes, is_exact, with_misses)  # steps 2 to 5
