"""The reference ball of a probe, where it is one of a fixture."""

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Feature, Fixture
from tactfix.settings import ONE_FEATURE
from tactfix.wording import did_you_mean, listed


def touches_of_ball(fixture: Fixture, contacts: Contacts, name: str | None = None) -> tuple[Feature, Contacts]:
    """The sphere that contacts touch, and those that touch it; name: which, where they touch several.

    Raises UsageError where it is none, or not the only one.
    """
    balls = [one for one, feature in fixture.features.items() if feature.type == "sphere"]
    if name is not None and name not in balls:
        raise UsageError(f"{fixture.name} has no sphere {name!r}; {did_you_mean(name, balls)}")
    touched = [one for one in balls if one in contacts.by_feature and name in (None, one)]
    if not touched:
        what = f"no contact touches {name or f'a sphere of {fixture.name}'}"
        raise UsageError(f"{what}; touch a ball of known radius from all sides")
    if len(touched) > 1:
        raise UsageError(f"the contacts touch {listed(touched)}, and one is the reference ball; " + ONE_FEATURE)
    return fixture.features[touched[0]], contacts.on(touched[0])
