"""`frozen_value`: a class of named, fixed fields, whose arrays and mappings are read-only copies.

Like `dataclasses.dataclass(frozen=True)`, with two differences. A field of type `Annotated[T, convert]` is converted on
construction (`geometry.arrays.Frozen`, `ReadOnly` here), so that no value shares an array that other code may write to;
copies and pickles use the constructor too. And one function is compiled for each class instead of the six of dataclass,
which took half of the import time of tactfix.
"""

import dataclasses
from collections.abc import Callable, Mapping
from types import MappingProxyType, UnionType
from typing import (
    Annotated,
    Any,
    Final,
    NoReturn,
    TypeAlias,
    TypeVar,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    overload,
)

T = TypeVar("T")
K = TypeVar("K")
V = TypeVar("V")


def read_only(mapping: Mapping[K, V]) -> Mapping[K, V]:
    """A read-only copy."""
    return MappingProxyType(dict(mapping))


ReadOnly: TypeAlias = Annotated[Mapping[K, V], read_only]
"""A mapping in a value."""


@overload
def frozen_value(cls: type[T]) -> type[T]: ...
@overload
def frozen_value(*, eq: bool) -> Callable[[type[T]], type[T]]: ...
@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field,))
def frozen_value(cls: type[T] | None = None, *, eq: bool = False) -> type[T] | Callable[[type[T]], type[T]]:
    """A class of values: its annotated names are the fields. Equality is identity, with eq that of all fields.

    `__post_init__` is called if defined; `dataclasses.replace` and `fields` work.
    """
    if cls is None:
        return lambda decorated: _made(decorated, eq=eq)
    return _made(cls, eq=eq)


def _made(cls: type[T], *, eq: bool) -> type[T]:
    dataclasses.dataclass(init=False, repr=False, eq=False)(cls)  # the fields alone
    methods: dict[str, object] = {
        "__init__": _constructor(cls),
        "__setattr__": _refuse,
        "__delattr__": _refuse,
        "__reduce__": _reduce,
    }
    if cls.__repr__ is object.__repr__:
        methods["__repr__"] = _repr
    if eq:
        methods |= {"__eq__": _eq, "__hash__": _hash}
    for name, method in methods.items():
        setattr(cls, name, method)
    return cls


def _constructor(cls: type) -> Callable[..., None]:
    """__init__ with the fields as parameters, each converted according to its type."""
    known: dict[str, object] = {"_set": object.__setattr__}
    parameters, lines = [], []
    for field in dataclasses.fields(cls):
        name, given = field.name, field.name
        if field.default is not dataclasses.MISSING:
            known[f"_default_{name}"] = field.default
            parameters.append(f"{name}=_default_{name}")
        elif field.default_factory is not dataclasses.MISSING:
            known |= {f"_make_{name}": field.default_factory, "_missing": dataclasses.MISSING}
            parameters.append(f"{name}=_missing")
            given = f"_make_{name}() if {name} is _missing else {name}"
        else:
            parameters.append(name)
        convert, optional = _conversion(field.type)
        if convert is not None:
            known[f"_convert_{name}"] = convert
            given = f"_convert_{name}({given})" + (f" if {name} is not None else None" if optional else "")
        lines.append(f" _set(self, {name!r}, {given})\n")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()\n")
    exec(f"def __init__(self, {', '.join(parameters)}):\n{''.join(lines) or ' pass'}", known)
    made: Any = known["__init__"]
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    made.__annotations__ = {**cls.__annotations__, "return": None}
    return made  # type: ignore[no-any-return]


def _conversion(annotation: object) -> tuple[Callable[[Any], object] | None, bool]:
    """The converter in a field's type, if any, and whether None is not converted."""
    if get_origin(annotation) is Annotated:
        return annotation.__metadata__[0], False  # type: ignore[attr-defined]
    if get_origin(annotation) in (Union, UnionType):
        for kind in get_args(annotation):
            if get_origin(kind) is Annotated:
                return kind.__metadata__[0], True
    return None, False


def _values(self: Any) -> tuple[object, ...]:
    return tuple([getattr(self, name) for name in self.__dataclass_fields__])


def _refuse(self: object, name: str, *_: object) -> NoReturn:
    raise dataclasses.FrozenInstanceError(f"{type(self).__name__} is a value: {name} cannot change")


def _repr(self: Any) -> str:
    fields = ", ".join(f"{name}={_brief(getattr(self, name))}" for name in self.__dataclass_fields__)
    return f"{type(self).__qualname__}({fields})"


_REPR_ELEMENTS: Final = 3
"""Largest number of elements that the repr shows of an array, a tuple or a mapping: enough for a vector."""
_REPR_CHARACTERS: Final = 80
"""Largest length of a nested text or value in a repr, so that it fits on one line."""


def _brief(value: Any) -> str:
    """The value inside the repr of another one; long values are given by their size."""
    if getattr(value, "shape", ()) and hasattr(value, "tolist"):
        return _brief_array(value)
    value = value.item() if hasattr(value, "item") else value  # a number of numpy
    if isinstance(value, Mapping):
        return f"<{', '.join(map(str, value))}>" if 0 < len(value) <= _REPR_ELEMENTS else f"<{len(value)} entries>"
    if isinstance(value, tuple) and (len(value) > _REPR_ELEMENTS or any(map(dataclasses.is_dataclass, value))):
        return f"<{len(value)} {type(value[0]).__name__}>"
    shown = f"{value:.7g}" if isinstance(value, float) else repr(value)
    if len(shown) <= _REPR_CHARACTERS:
        return shown
    return f"{shown[:_REPR_CHARACTERS]}..." if isinstance(value, str) else f"<{type(value).__name__}>"


def _brief_array(array: Any) -> str:
    if array.ndim == 1 and array.size <= _REPR_ELEMENTS and array.dtype.kind in "fiub":
        return f"[{', '.join(f'{number:.6g}' for number in array.tolist())}]"
    return f"<array {' x '.join(map(str, array.shape))}>"


def _reduce(self: Any) -> tuple[object, ...]:
    values = _values(self)
    return type(self), tuple([dict(given) if isinstance(given, MappingProxyType) else given for given in values])


def _eq(self: Any, other: object) -> bool:
    return _values(self) == _values(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_values(self))
