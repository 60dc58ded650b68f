"""The kinds of a part of a scenario, such as of faults: models that packages register by entry points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_args

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema
from pydantic_core.core_schema import ValidationInfo

from uwsim.base.sockets import Adapt, EntryError, load, load_all, registered
from uwsim.scenario.spec.fields import Model, OneOf, broken


@dataclass(frozen=True)
class Kinds:
    """A type annotation: one of the registered kinds, chosen by its key `kind`, or another.

    group: the entry points, whose names are the kinds and whose objects are their models. base: the class of all of
    them. key: the field that has the kind's name. needs: further fields that each of them must define. The models are
    loaded when the first value is validated, so that they may import all of uwsim; those of other packages only for a
    kind that is not one of uwsim's.
    """

    group: str
    base: type[Model]
    key: str = "kind"
    needs: tuple[str, ...] = ()

    def models(self, *, own: bool = False) -> Mapping[str, type[Any]]:
        """Return the models by kind. own: only uwsim's. Warns with SocketWarning of entries that are no such model."""
        return load_all(self.group, self._fitting, own=own)

    def _fitting(self, name: str, model: Any) -> type[Any]:
        if not (isinstance(model, type) and issubclass(model, self.base)):
            raise TypeError(f"must be a class derived from {self.base.__module__}.{self.base.__name__}")
        if self.key not in model.model_fields or get_args(model.model_fields[self.key].annotation) != (name,):
            raise TypeError(f'must have the field `{self.key}: Literal["{name}"]`')
        if missing := [field for field in self.needs if field not in model.model_fields]:
            raise TypeError(f"must have the fields {', '.join(missing)}")
        return model

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        any_kind = core_schema.simple_ser_schema("any")
        return core_schema.with_info_plain_validator_function(self._validated, serialization=any_kind)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(_union(self, own=False).core_schema)

    def _validated(self, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, self.base):
            return value
        own = isinstance(value, Mapping) and value.get(self.key) in list(self.models(own=True))
        return _union(self, own=own).validate_python(value, context=info.context)


@dataclass(frozen=True)
class KindName:
    """A type annotation: the name of an object that is registered in a group. adapt: see `uwsim.base.sockets`."""

    group: str
    adapt: Adapt

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"enum": list(load_all(self.group, self.adapt))}

    def _check(self, name: str) -> str:
        OneOf(tuple(registered(self.group))).check(name)
        try:
            load(self.group, name, self.adapt)
        except EntryError as error:
            raise broken(str(error)) from error
        return name


@cache
def _union(kinds: Kinds, own: bool) -> TypeAdapter[Any]:
    return TypeAdapter(Annotated[Any, _Tagged(kinds, own)])


@dataclass(frozen=True)
class _Tagged:
    kinds: Kinds
    own: bool

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        models = self.kinds.models(own=self.own)
        return core_schema.tagged_union_schema(
            {name: handler.generate_schema(model) for name, model in models.items()}, discriminator=self.kinds.key
        )
